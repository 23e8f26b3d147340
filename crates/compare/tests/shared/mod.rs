//! The shared reference pictures, where they are.

use std::path::PathBuf;

use glam::DVec2;
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{Frame, Layer, Picture, PixelWindow, Plane};

/// A file of the shared folder, or `None`, said aloud, where there is no such folder.
#[expect(clippy::print_stdout, reason = "a test that is skipped must say so")]
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

/// Planar depth, focal length 1777.8 px, an untilted lens of `aperture_diameter` focused at `focus`.
pub(crate) fn blender_frame(picture: Picture, depth: Plane, focus: f64, aperture_diameter: f64) -> (Frame, Camera) {
    let display = picture.window();
    let half = DVec2::new(f64::from(display.width), f64::from(display.height)) / (2.0 * 1777.8);
    let camera = Camera {
        pose: Pose::IDENTITY,
        film: Film::new(-half, half, display.width, display.height).unwrap(),
        focus: Focus::at_depth(focus).unwrap(),
        iris: Iris::upright(aperture_diameter / 2.0, ApertureShape::Disc).unwrap(),
    };
    (Frame::new(display, vec![Layer::from_raw_depth(picture, depth)]).unwrap(), camera)
}
