//! The main job on files that nobody here wrote: focus at a pixel, tilt the lens, and a picture comes out that is sharp
//! where it should be, blurred elsewhere, and sound at its border. There is no truth to compare with.
//!
//! The pictures are left as PNG files in the build's folder for temporary files, to be looked at.

mod support {
    pub(crate) mod foreign;
    pub(crate) mod shared;
}

use optics::ThinLens;
use rgbd::PixelWindow;
use support::foreign::{Foreign, Taken};
use support::shared;

fn report(name: &str, taken: &Taken, t: std::time::Instant) {
    let inside = taken.picture.window();
    eprintln!("{name} {:?} sound {} sharp {:.4} blurred {:.4} whole {:.4}", t.elapsed(), taken.is_sound(), taken.detail_left(0.0..0.25), taken.detail_left(3.0..f32::INFINITY), taken.brightness(inside));
    let most = taken.coc.values().iter().filter(|c| c.is_finite()).fold(0.0f32, |a, b| a.max(b.abs()));
    eprintln!("  most {most}");
    for (side, strip) in taken.border(8) {
        eprintln!("  {side} {:.4}", taken.brightness(strip));
    }
}

#[test]
fn blenders_table_top() {
    let Some(folder) = shared::folder() else { return };
    // The file does not say so: a 50 mm lens before 36 mm of sensor
    let fov = 2.0 * (18.0_f64 / 50.0).atan();
    for name in ["blender_tabletop_multilayer", "blender_tabletop_rgbaz_half_piz"] {
        let t = std::time::Instant::now();
        let foreign = Foreign::read(&folder, name, fov);
        let lens = ThinLens::new(0.5, 2.8, 0.52).and_then(|lens| lens.tilted(6_f64.to_radians(), 0.0)).expect("a lens");
        let taken = foreign.take(lens, (500, 315), PixelWindow::of_size(960, 540));
        report(name, &taken, t);
    }
}

#[test]
fn beachball() {
    let Some(folder) = shared::folder() else { return };
    for (name, data) in [("beachball_singlepart.0001", PixelWindow { x: 654, y: 245, width: 911, height: 876 }), ("beachball_multipart.0003",PixelWindow { x: 864, y: 481, width: 879, height: 855 })] {
        let t = std::time::Instant::now();
        let foreign = Foreign::read(&folder, name, 40_f64.to_radians());
        let lens = ThinLens::new(0.5, 2.5, 0.52).and_then(|lens| lens.tilted(2_f64.to_radians(), 0.0)).expect("a lens");
        let taken = foreign.take(lens, (data.x + 455, data.y + 430), data.grown(40, 40));
        report(name, &taken, t);
    }
}
