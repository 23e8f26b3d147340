//! The traced spot of a small light against the closed form of where a point lands.
#![allow(clippy::print_stdout)] // tests say what they measured

use glam::{DAffine3, DMat2, DQuat, DVec2, DVec3, Vec3};
use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
use rgbd::{PixelWindow, Silent};
use trace::{Material, SceneBuilder, Shape};

const SPP: u32 = 8192;
/// Edge of the light, as the pinhole sees it.
const LIGHT_PX: f64 = 3.0;
/// Radius of the spot that the aperture is chosen for.
const SPOT_PX: f64 = 12.0;

/// A lens, and the light before it.
struct Setup {
    name: &'static str,
    w: DVec3,
    normal: DVec3,
    shape: ApertureShape,
    squeeze: f64,
    cat_eye: f64,
    p: DVec2,
    depth: f64,
}

/// Energy, centroid and second moments of a spot in pixels.
#[derive(Debug, Clone, Copy, Default)]
struct Spot {
    energy: f64,
    centroid: DVec2,
    spread: DMat2,
}

impl Spot {
    fn of(points: &[(DVec2, f64)]) -> Self {
        let energy: f64 = points.iter().map(|(_, weight)| weight).sum();
        let centroid = points.iter().map(|&(p, weight)| weight * p).sum::<DVec2>() / energy;
        let outer = |d: DVec2| DMat2::from_cols(d.x * d, d.y * d);
        let spread = points.iter().map(|&(p, weight)| outer(p - centroid) * weight).sum::<DMat2>() * (1.0 / energy);
        Self { energy, centroid, spread }
    }
}

fn camera(setup: &Setup) -> Camera {
    let film = Film::new(DVec2::new(-0.5, -0.3), DVec2::new(0.5, 0.3), 640, 384).unwrap();
    let focus = Focus::new(setup.w).unwrap();
    let defocus = 1.0 / setup.depth - focus.inverse_depth(setup.p);
    let radius = SPOT_PX / (defocus.abs() * film.pixels_per_q().x);
    let iris = Iris::new(setup.normal, radius, setup.shape).unwrap().squeezed(setup.squeeze).unwrap();
    Camera { pose: Pose::IDENTITY, film, focus, iris }.with_cat_eye(setup.cat_eye).unwrap()
}

/// Where the point (p, 1) / inverse depth lands through L: q - p = -D (l - l_z p) / (1 - w.L - D l_z).
fn landing(w: DVec3, p: DVec2, inverse_depth: f64, l: DVec3) -> DVec2 {
    let defocus = inverse_depth - w.dot(p.extend(1.0));
    p - defocus * (l.truncate() - l.z * p) / (1.0 - w.dot(l) - defocus * l.z)
}

/// The spot by the closed form, over a grid of the light and of the iris.
fn expected(setup: &Setup, camera: &Camera) -> Spot {
    let (light_steps, lens_steps) = (6, 96);
    let middle = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
    let side = LIGHT_PX / camera.film.pixels_per_q().x;
    let mut points = Vec::new();
    for u in (0..lens_steps * lens_steps)
        .map(|i| DVec2::new(middle(i % lens_steps, lens_steps), middle(i / lens_steps, lens_steps)))
    {
        let l = camera.iris.point(u);
        let land = |p: DVec2| landing(setup.w, p, 1.0 / setup.depth, l);
        for i in 0..light_steps * light_steps {
            let place = DVec2::new(middle(i % light_steps, light_steps), middle(i / light_steps, light_steps));
            let p = setup.p + (place - 0.5) * side;
            // What the light's piece covers in q, by central differences
            let h = 1e-5;
            let [dx, dy] = [DVec2::X, DVec2::Y].map(|axis| (land(p + h * axis) - land(p - h * axis)) / (2.0 * h));
            let area = DMat2::from_cols(dx, dy).determinant().abs();
            // A pixel that sees less of the lens takes the mean over that
            let opening = camera.iris.opening(land(p));
            let weight = if opening.is_within_rim(setup.shape.sample(u)) { area / opening.share() } else { 0.0 };
            points.push((camera.film.pixel_from_q(land(p)), weight));
        }
    }
    let spot = Spot::of(&points);
    Spot { energy: spot.energy / points.len() as f64 * LIGHT_PX * LIGHT_PX, ..spot }
}

/// The spot as it is traced.
fn traced(setup: &Setup, camera: &Camera, around: DVec2) -> Spot {
    let half_side = 0.5 * LIGHT_PX / camera.film.pixels_per_q().x * setup.depth;
    let (across, z) = (setup.p * setup.depth, -setup.depth);
    let map = DAffine3::from_scale_rotation_translation(
        DVec3::splat(half_side),
        DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
        across.extend(z),
    );
    let mut builder = SceneBuilder::new();
    let glow = builder.material(Material::glowing(Vec3::ONE));
    builder.shape(Shape::Rectangle, map, glow).unwrap();
    let scene = builder.build().unwrap();
    let [x, y] = around.round().to_array().map(|x| x as i32);
    let window = PixelWindow::from_corners(x - 24, y - 24, x + 24, y + 24);
    let picture = trace::truth(&scene, camera, window, SPP, 4, &Silent).unwrap().picture();
    assert!(
        window
            .grown(0, 0)
            .pixels()
            .filter(|&(i, j)| (i - x).abs() > 22 || (j - y).abs() > 22)
            .all(|(i, j)| { picture.at(i, j)[0] == 0.0 })
    );
    let points = window
        .pixels()
        .map(|(x, y)| (DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5), f64::from(picture.at(x, y)[0])));
    let spot = Spot::of(&points.collect::<Vec<_>>());
    // Sheppard's correction: a box of one pixel has a variance of 1/12
    Spot { spread: spot.spread - DMat2::from_diagonal(DVec2::splat(1.0 / 12.0)), ..spot }
}

#[test]
fn a_small_light_makes_the_spot_that_the_closed_form_says() {
    let tilted = |w: DVec3, v: f64| w + DVec3::Z / v;
    let setup = |name, w: [f64; 3], v: f64, shape, p: [f64; 2], depth| {
        let w = DVec3::from_array(w);
        Setup { name, w, normal: tilted(w, v), shape, squeeze: 1.0, cat_eye: 0.0, p: DVec2::from_array(p), depth }
    };
    let disc = ApertureShape::Disc;
    let pentagon = ApertureShape::polygon(5, 0.4).unwrap();
    let setups = [
        setup("untilted", [0.0, 0.0, 0.1], 2.0, disc, [0.1, 0.05], 5.0),
        setup("tilted by 10 degrees", [0.0, -0.1, 0.08], 2.0, disc, [-0.2, 0.15], 5.0),
        setup("tilted by 34 degrees, focused behind the camera", [0.02, -0.3, -0.05], 2.0, disc, [-0.1, 0.2], 4.0),
        setup("swung, beyond the focus", [0.4, 0.1, 0.3], 1.0, disc, [0.2, -0.1], 12.0),
        Setup {
            normal: DVec3::Z,
            ..setup("upright iris with five blades", [0.1, -0.2, 0.1], 1.0, pentagon, [0.15, 0.1], 3.0)
        },
        Setup {
            squeeze: 2.0,
            ..setup("tilted anamorphic lens with five blades", [0.02, -0.2, 0.1], 1.0, pentagon, [0.1, 0.1], 4.0)
        },
        Setup { cat_eye: 1.0, ..setup("cat's eye in the corner", [0.0, 0.0, 0.1], 1.0, disc, [0.45, 0.26], 3.0) },
        Setup { cat_eye: 0.8, ..setup("cat's eye behind the focus", [0.0, 0.0, 0.5], 1.0, disc, [-0.42, 0.1], 9.0) },
        Setup {
            cat_eye: 0.7,
            squeeze: 0.8,
            ..setup("tilted, anamorphic cat's eye with five blades", [0.02, -0.2, 0.1], 1.0, pentagon, [0.3, -0.2], 4.0)
        },
    ];
    for setup in setups {
        let camera = camera(&setup);
        let law = expected(&setup, &camera);
        let spot = traced(&setup, &camera, law.centroid);
        println!("{}: {spot:?}\n    expected {law:?}", setup.name);
        assert!((spot.energy / law.energy - 1.0).abs() < 0.005, "{}: energy", setup.name);
        assert!((spot.centroid - law.centroid).length() < 0.05, "{}: centroid", setup.name);
        let off = spot.spread - law.spread;
        let size = 0.5 * (law.spread.x_axis.x + law.spread.y_axis.y);
        let worst = off.to_cols_array().into_iter().fold(0.0_f64, |worst, x| worst.max(x.abs()));
        assert!(worst < 0.01 * size, "{}: second moments off by {worst} of {size}", setup.name);
        // 20 px across, as a disc of that variance
        assert!(4.0 * size.sqrt() > 20.0 || setup.shape != disc || setup.cat_eye > 0.0, "{}: {size}", setup.name);
    }
}

#[test]
fn an_anamorphic_lens_makes_spots_as_wide_and_high_as_it_is_squeezed() {
    for (squeeze, half_sizes) in [(2.0, DVec2::new(0.5, 1.0)), (0.8, DVec2::new(1.0, 0.8))] {
        let w = DVec3::new(0.0, 0.0, 0.1);
        let setup = Setup {
            name: "anamorphic",
            w,
            normal: DVec3::Z,
            shape: ApertureShape::Disc,
            squeeze,
            cat_eye: 0.0,
            p: DVec2::new(0.001, 0.002),
            depth: 5.0,
        };
        let camera = camera(&setup);
        let around = camera.film.pixel_from_q(setup.p);
        // A uniform ellipse has a variance of a quarter of its half axis squared, a square light of side^2 / 12
        let wanted = (SPOT_PX * half_sizes).powf(2.0) / 4.0 + LIGHT_PX * LIGHT_PX / 12.0;
        let found = traced(&setup, &camera, around).spread;
        let off = DVec2::new(found.x_axis.x, found.y_axis.y) - wanted;
        assert!((off / wanted).abs().max_element() < 0.01, "{found} {wanted}");
    }
}
