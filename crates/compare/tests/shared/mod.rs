//! The shared reference pictures, where they are.

use std::path::PathBuf;

use rgbd::{Picture, PixelWindow, Plane};

/// A file of the shared folder, or `None`, said aloud, where there is no such folder.
pub(crate) fn file(name: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("TILTSHIFT_SHARED") else {
        println!("skipped: TILTSHIFT_SHARED is not set");
        return None;
    };
    Some(PathBuf::from(root).join(name))
}

/// R, G, B and, where there is one, Z of an EXR file whose windows start at (0, 0).
pub(crate) fn load(name: &str) -> Option<(Picture, Option<Plane>)> {
    let path = file(name)?;
    let image = exr::prelude::read_first_flat_layer_from_file(&path).unwrap_or_else(|e| panic!("{name}: {e}"));
    let size = image.layer_data.size;
    let window = PixelWindow::of_size(size.0 as u32, size.1 as u32);
    let channel = |wanted: &str| {
        let list = &image.layer_data.channel_data.list;
        let channel = list.iter().find(|channel| channel.name.eq(wanted))?;
        Plane::from_values(window, channel.sample_data.values_as_f32().collect())
    };
    let [r, g, b] = ["R", "G", "B"].map(|name| channel(name).expect("a colour channel"));
    let picture = Picture::from_planes([r, g, b, Plane::filled(window, 1.0)]).expect("one window");
    Some((picture, channel("Z")))
}
