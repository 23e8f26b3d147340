//! What mirrors show, traced and filtered by its optical depth.
#![allow(clippy::print_stdout)] // tests say what they measured

use filter::{FrameView, Method, apply};
use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{Frame, Picture, PixelWindow, Silent};
use trace::{Finish, LayerSettings, Light, Material, Matter, Pigment, Scene, SceneBuilder, Shape};

const DISPLAY: PixelWindow = PixelWindow { x: 0, y: 0, width: 96, height: 54 };

/// Farther from the mirror's rim than its image is blurred.
const INSIDE: PixelWindow = PixelWindow { x: 27, y: 19, width: 42, height: 16 };

/// Depth of the mirror, of the checker in it and of the wall behind it.
const MIRROR: f64 = 4.0;
const IMAGE: f64 = 11.0;
const WALL: f64 = 6.0;

fn rmse(a: &Picture, b: &Picture, window: PixelWindow) -> f64 {
    let squares =
        window.pixels().flat_map(|(x, y)| (0..3).map(move |c| f64::from(a.at(x, y)[c] - b.at(x, y)[c]).powi(2)));
    (squares.sum::<f64>() / (3.0 * window.area() as f64)).sqrt()
}

/// A checker seen in a mirror that hangs before a wall; or, unfolded, the checker alone where its image is.
fn scene(is_folded: bool) -> Scene {
    let mut builder = SceneBuilder::new();
    let colors = [Vec3::new(0.9, 0.8, 0.3), Vec3::new(0.05, 0.1, 0.3)];
    let pigment = Pigment::Checker { colors, side: 1.0, axes: [0, 1] };
    let checker = builder.material(Material { pigment, emission: Vec3::ZERO });
    let grey = builder.material(Material::matte(Vec3::new(0.4, 0.1, 0.1)));
    let matter = Matter::Glossy { metallic: 1.0, roughness: 0.0, ior: 1.5 };
    let silver = builder.finished(Material::matte(Vec3::ONE), Finish { matter, ..Finish::default() });
    // One bounce, off the mirror: walls that light each other would look brighter than the unfolded one
    builder.light(Light::Ambient { strength: Vec3::ONE });
    builder.bounces(1).unwrap();
    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let at = |scale: DVec3, z: f64| DAffine3::from_scale_rotation_translation(scale, upright, DVec3::new(0.0, 0.0, -z));
    if is_folded {
        builder.shape(Shape::Plane, at(DVec3::ONE, 2.0 * MIRROR - IMAGE), checker).unwrap();
        builder.shape(Shape::Plane, at(DVec3::ONE, WALL), grey).unwrap();
        builder.shape(Shape::Rectangle, at(DVec3::new(1.2, 1.0, 0.7), MIRROR), silver).unwrap();
    } else {
        builder.shape(Shape::Plane, at(DVec3::ONE, IMAGE), checker).unwrap();
    }
    builder.build().unwrap()
}

/// 100 pixels for a unit of q.
fn camera(focus: f64, tilt: f64) -> Camera {
    Camera {
        pose: Pose::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y).unwrap(),
        film: Film::new(DVec2::new(-0.48, -0.27), DVec2::new(0.48, 0.27), DISPLAY.width, DISPLAY.height).unwrap(),
        focus: Focus::new(DVec3::new(tilt, 0.0, 1.0 / focus)).unwrap(),
        iris: Iris::upright(0.4, ApertureShape::Disc).unwrap(),
    }
}

fn filtered(frame: &Frame, camera: &Camera, method: &Method) -> Picture {
    apply(&FrameView::whole(frame), camera, method, DISPLAY, &Silent).unwrap().picture
}

/// A plane in a plane mirror is blurred like the unfolded scene, whatever is in focus: the mirror, the image, or a tilted plane;
/// at the rim of the mirror it comes nearer to the truth than by the depth of the mirror.
#[test]
fn a_plane_mirror_is_filtered_like_the_unfolded_scene() {
    let [folded, unfolded] = [true, false].map(scene);
    let settings = LayerSettings { color_samples: 256, ..LayerSettings::default() };
    for (name, camera) in
        [("mirror", camera(MIRROR, 0.0)), ("image", camera(IMAGE, 0.0)), ("tilted plane", camera(WALL, 0.15))]
    {
        let truth = |scene: &Scene| trace::truth(scene, &camera, DISPLAY, 512, 3, &Silent).unwrap().picture();
        let [truth, twin] = [truth(&folded), truth(&unfolded)];
        // Two pictures of one thing; 512 samples over steps of 0.8 leave 0.01 at most
        assert!(rmse(&truth, &twin, INSIDE) < 0.01, "{name}: the mirror shows the unfolded scene");
        let frame = |scene: &Scene| trace::layers(scene, &camera, &settings, &Silent).unwrap().frame;
        let [mirrored, twin] = [frame(&folded), frame(&unfolded)];
        assert!(mirrored.optical_depth().is_some() && twin.optical_depth().is_none());
        for method in [Method::Gather(Default::default()), Method::default(), Method::LensRays(Default::default())] {
            let [known, unknown, twin] = [mirrored.clone(), mirrored.clone().without_optical_depth(), twin.clone()]
                .map(|frame| filtered(&frame, &camera, &method));
            let error = |picture: &Picture| rmse(picture, &truth, DISPLAY);
            println!(
                "focus on the {name}, {}: RMSE {:.4}, by the mirror's depth {:.4}; from the unfolded one inside {:.5}",
                method.name(),
                error(&known),
                error(&unknown),
                rmse(&known, &twin, INSIDE)
            );
            // The same colours and the same blur, but for the depth of the image, which is told by differences of rays
            assert!(rmse(&known, &twin, INSIDE) < 0.004, "{name}: {}", rmse(&known, &twin, INSIDE));
            // Measured: 0.19, 0.29 and 0.58; what is left is the rim, behind which the image goes on by a guess
            assert!(error(&known) < 0.65 * error(&unknown), "{name}: {} and {}", error(&known), error(&unknown));
        }
    }
}
