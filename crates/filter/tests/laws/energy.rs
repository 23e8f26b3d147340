//! Light is neither made nor lost.

use filter::{GatherSettings, KernelRule, Method};
use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, KernelModel, Pose};
use rgbd::{Frame, PixelWindow};

use crate::scenes::{filtered, layer, noise};

#[test]
fn at_one_depth_the_light_is_kept_for_every_iris_and_radius() {
    // A patch of noise on a black wall, its borders farther than twice the blur. Every pixel of the wall has the same kernel, so
    // that what the weights fall short of 1 is made up for by the normalisation
    const KEPT: f64 = 1e-4;
    // Between cells colours are kept within those around, so that no lamp leaves a dark ring: 1.03e-4 at worst here
    const KEPT_MERGED: f64 = 1.5e-4;
    let display = PixelWindow::of_size(160, 160);
    let lit = PixelWindow { x: 61, y: 66, width: 37, height: 31 };
    let wall = layer(
        display.grown(24, 24),
        |x, y| if lit.contains(x, y) { noise(x, y, 9).powi(4) * 8.0 } else { 0.0 },
        |_, _| 2.0,
    );
    let frame = Frame::new(display, vec![wall]).unwrap();
    let given = sum(&frame, |x, y| frame.layers()[0].color.at(x, y)[0]);

    let polygon = |blades| ApertureShape::polygon(blades, 0.3).unwrap();
    let tilted = DVec3::new(0.1, -0.25, 1.0);
    let irises = [
        (ApertureShape::Disc, DVec3::Z, KernelModel::Disc, 1.0),
        (polygon(5), DVec3::Z, KernelModel::Disc, 1.0),
        (polygon(6), DVec3::Z, KernelModel::Disc, 1.0),
        (ApertureShape::Disc, tilted, KernelModel::Ellipse, 1.0),
        (polygon(5), tilted, KernelModel::Ellipse, 0.5),
    ];
    for (shape, normal, model, squeeze) in irises {
        for radius in [0.3, 0.5, 0.55, 1.0, 1.7, 3.9, 9.0, 12.5, 21.0, 40.0] {
            for behind in [-1.0, 1.0] {
                // So many pixels per unit of q that the ellipse is the same all over the picture
                let camera = Camera {
                    pose: Pose::IDENTITY,
                    film: Film::new(DVec2::splat(-0.01), DVec2::splat(0.01), 160, 160).unwrap(),
                    focus: Focus::new(DVec3::new(0.0, 0.0, 0.5 + 0.25 * behind)).unwrap(),
                    iris: Iris::new(normal, radius / (8000.0 * 0.25), shape).unwrap().squeezed(squeeze).unwrap(),
                };
                let settings = GatherSettings {
                    kernel: KernelRule::Forced(model),
                    max_radius_px: Some(64.0),
                    ..GatherSettings::default()
                };
                for (method, kept) in [(Method::Gather(settings), KEPT), (Method::Merged(settings), KEPT_MERGED)] {
                    let picture = filtered(&frame, &camera, &method);
                    let found = sum(&frame, |x, y| picture.at(x, y)[0]);
                    let off = found / given - 1.0;
                    assert!(off.abs() <= kept, "{} {shape:?} {model:?} radius {radius}: off by {off:e}", method.name());
                }
            }
        }
    }
}

fn sum(frame: &Frame, value: impl Fn(i32, i32) -> f32) -> f64 {
    frame.display.pixels().map(|(x, y)| f64::from(value(x, y))).sum()
}
