//! Frames and lenses that the laws are tried on.

use filter::{FrameView, GatherSettings, KernelRule, LensRaysSettings, Method, apply};
use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, KernelModel, Pose};
use rgbd::{Frame, Layer, Picture, PixelWindow, Plane, Silent};

pub(crate) const DISPLAY: PixelWindow = PixelWindow { x: 0, y: 0, width: 64, height: 48 };

/// 100 pixels per unit of q, an upright or tilted iris of `radius`, focus w.
pub(crate) fn camera(w: DVec3, normal: DVec3, radius: f64, shape: ApertureShape) -> Camera {
    Camera {
        pose: Pose::IDENTITY,
        film: Film::new(DVec2::new(-0.32, -0.24), DVec2::new(0.32, 0.24), DISPLAY.width, DISPLAY.height).unwrap(),
        focus: Focus::new(w).unwrap(),
        iris: Iris::new(normal, radius, shape).unwrap(),
    }
}

/// The same lens over another display window, at as many pixels per unit of q.
pub(crate) fn over(display: PixelWindow, camera: &Camera) -> Camera {
    let half = DVec2::new(f64::from(display.width), f64::from(display.height)) / 200.0;
    Camera { film: Film::new(-half, half, display.width, display.height).unwrap(), ..*camera }
}

pub(crate) fn untilted(focus_depth: f64, radius: f64) -> Camera {
    camera(DVec3::new(0.0, 0.0, 1.0 / focus_depth), DVec3::Z, radius, ApertureShape::Disc)
}

/// One layer from functions of the pixel.
pub(crate) fn layer(window: PixelWindow, color: impl Fn(i32, i32) -> f32, depth: impl Fn(i32, i32) -> f32) -> Layer {
    let color = Picture::from_fn(window, |x, y| [color(x, y), color(x, y), color(x, y), 1.0]);
    Layer::from_raw_depth(color, Plane::from_fn(window, depth))
}

pub(crate) fn filtered(frame: &Frame, camera: &Camera, method: &Method) -> Picture {
    apply(&FrameView::whole(frame), camera, method, frame.display, &Silent).unwrap().picture
}

pub(crate) fn forced(kernel: KernelModel) -> GatherSettings {
    GatherSettings { kernel: KernelRule::Forced(kernel), ..GatherSettings::default() }
}

/// Without the hidden layers.
pub(crate) fn one_layer() -> GatherSettings {
    GatherSettings { layers: 1, ..GatherSettings::default() }
}

pub(crate) fn rays(samples: u32) -> Method {
    Method::LensRays(LensRaysSettings { samples, ..LensRaysSettings::default() })
}

pub(crate) fn all_methods() -> Vec<Method> {
    let kernels = [KernelModel::Disc, KernelModel::Ellipse, KernelModel::Exact];
    let blurs = kernels.into_iter().flat_map(|kernel| {
        [Method::OwnCoc(forced(kernel)), Method::Gather(forced(kernel)), Method::Merged(forced(kernel))]
    });
    [Method::Pinhole, rays(16)].into_iter().chain(blurs).collect()
}

pub(crate) fn lenses() -> Vec<Camera> {
    let pentagon = ApertureShape::polygon(5, 0.3).unwrap();
    let (tilted, z) = (DVec3::new(0.1, -0.15, 1.0), DVec3::Z);
    let anamorphic = camera(DVec3::new(0.2, -0.4, 0.4), tilted, 0.15, pentagon);
    vec![
        camera(DVec3::new(0.0, 0.0, 0.5), z, 0.0, ApertureShape::Disc),
        camera(DVec3::new(0.0, 0.0, 0.5), z, 0.2, ApertureShape::Disc),
        camera(DVec3::new(0.3, -1.5, 0.2), z, 0.15, pentagon),
        camera(DVec3::new(0.2, -0.4, 0.4), tilted, 0.15, ApertureShape::Disc),
        camera(DVec3::new(-2.0, 1.0, -0.1), tilted, 0.08, pentagon),
        Camera { iris: anamorphic.iris.squeezed(0.3).unwrap(), ..anamorphic },
        camera(DVec3::new(0.1, -0.3, 0.3), tilted, 0.2, ApertureShape::Disc).with_cat_eye(0.9).unwrap(),
    ]
}

/// A cheap, repeatable number in [0, 1) from a pixel.
pub(crate) fn noise(x: i32, y: i32, salt: u32) -> f32 {
    let mut h =
        (x as u32).wrapping_mul(0x9E37_79B9) ^ (y as u32).wrapping_mul(0x85EB_CA6B) ^ salt.wrapping_mul(0xC2B2_AE35);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    (h >> 8) as f32 / (1 << 24) as f32
}

/// Random steps in depth from 1 to 8, some sky, some holes, a patchy hidden layer; colours from `color`.
pub(crate) fn rough_frame(display: PixelWindow, data: PixelWindow, color: impl Fn(i32, i32, u32) -> f32) -> Frame {
    let depth = |x: i32, y: i32| match noise(x.div_euclid(7), y.div_euclid(5), 1) {
        n if n < 0.1 => f32::INFINITY,
        n if n < 0.2 => f32::NAN,
        n => 1.0 + 7.0 * n,
    };
    let front = layer(data, |x, y| color(x, y, 2), depth);
    let is_there = |x: i32, y: i32| noise(x.div_euclid(6), y.div_euclid(6), 3) < 0.3;
    let hidden_color =
        |x, y| if is_there(x, y) { [color(x, y, 4), color(x, y, 4), color(x, y, 4), 1.0] } else { [0.0; 4] };
    let hidden_depth = |x, y| if is_there(x, y) { 9.0 } else { f32::NAN };
    let hidden = Layer::from_raw_depth(Picture::from_fn(data, hidden_color), Plane::from_fn(data, hidden_depth));
    Frame::new(display, vec![front, hidden]).unwrap()
}
