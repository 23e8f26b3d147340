//! Rung 3 is rung 2 at another cost.

use filter::{GatherSettings, Method};
use glam::{DVec3, Vec3};
use optics::{ApertureShape, Camera, Film};
use rgbd::{Frame, Layer, Picture, PixelWindow, Plane};

use crate::scenes::{camera, filtered, layer, noise, over};

const DISPLAY: PixelWindow = PixelWindow { x: 0, y: 0, width: 320, height: 200 };

/// A textured floor with boxes on it under a plain sky: colour of 16 samples, depth of one.
fn boxes() -> Frame {
    let data = DISPLAY.grown(24, 24);
    let hit = |x: f32, y: f32| {
        let q = Vec3::new((x + 0.5 - 160.0) / 100.0, (100.0 - y - 0.5) / 100.0, 1.0);
        let mut nearest = (f32::INFINITY, 0.8);
        // The floor, in squares with noise on them
        if q.y < 0.0 {
            let z = -1.0 / q.y;
            let (u, v) = (z * q.x, z);
            let square = ((2.0 * u).floor() + (2.0 * v).floor()) as i32;
            let grain = noise((u * 40.0).floor() as i32, (v * 40.0).floor() as i32, 5);
            nearest = (z, 0.2 + 0.5 * square.rem_euclid(2) as f32 + 0.3 * grain);
        }
        for i in 0..14 {
            let random = |k: u32| noise(i, 3, 20 + k);
            let low = Vec3::new(-6.0 + 12.0 * random(0), -1.0, 2.0 + 10.0 * random(1));
            let high = low + Vec3::new(0.4 + random(2), 0.3 + 1.5 * random(3), 0.4 + random(4));
            let (a, b) = (low / q, high / q);
            let (enter, leave) = (a.min(b), a.max(b));
            let z = enter.max_element();
            if z <= leave.min_element() && z > 0.0 && z < nearest.0 {
                let side = if z == enter.x {
                    0.6
                } else if z == enter.y {
                    1.0
                } else {
                    0.8
                };
                let p = q * z * 20.0;
                let grain = noise(p.x.floor() as i32, p.y.floor() as i32 * 31 + p.z.floor() as i32, 6);
                nearest = (z, side * (0.2 + 0.6 * random(5) + 0.2 * grain));
            }
        }
        nearest
    };
    let color = Picture::from_fn(data, |x, y| {
        let mut sum = [0.0, 0.0, 0.0, 1.0];
        for k in 0..16 {
            let offset = |k: i32| (k as f32 + 0.5) / 4.0 - 0.5;
            let (z, c) = hit(x as f32 + offset(k % 4), y as f32 + offset(k / 4));
            let rgb = if z.is_finite() { [c, 0.9 * c, 0.7 * c] } else { [0.4, 0.6, 0.9] };
            (0..3).for_each(|i| sum[i] += rgb[i] / 16.0);
        }
        sum
    });
    let depth = Plane::from_fn(data, |x, y| hit(x as f32, y as f32).0);
    Frame::new(DISPLAY, vec![Layer::from_raw_depth(color, depth)]).unwrap()
}

#[test]
fn merged_neighbours_make_the_same_picture() {
    // What issue 3 asks for
    const MEAN: f64 = 1e-3;
    const HIGH: f64 = 0.02;
    let frame = boxes();
    let lenses: [(&str, Camera); 4] = [
        ("near focus", camera(DVec3::new(0.0, 0.0, 0.45), DVec3::Z, 0.4, ApertureShape::Disc)),
        ("far focus", camera(DVec3::new(0.0, 0.0, 0.08), DVec3::Z, 0.5, ApertureShape::polygon(6, 0.1).unwrap())),
        ("along the floor", camera(DVec3::new(0.0, -0.9, 0.05), DVec3::Z, 0.9, ApertureShape::Disc)),
        ("tilted iris", camera(DVec3::new(0.1, 0.5, 0.2), DVec3::new(0.0, -0.2, 1.0), 0.5, ApertureShape::Disc)),
    ];
    for (name, lens) in lenses {
        let settings = GatherSettings::default();
        let lens = over(DISPLAY, &lens);
        let [plain, merged] =
            [Method::Gather(settings), Method::Merged(settings)].map(|method| filtered(&frame, &lens, &method));
        let pixels = || DISPLAY.pixels().flat_map(|(x, y)| (0..3).map(move |c| (x, y, c)));
        let mean = pixels().map(|(x, y, c)| f64::from(plain.at(x, y)[c])).sum::<f64>() / pixels().count() as f64;
        let mut off: Vec<f64> =
            pixels().map(|(x, y, c)| f64::from((plain.at(x, y)[c] - merged.at(x, y)[c]).abs())).collect();
        off.sort_by(f64::total_cmp);
        let high = off[off.len() * 999 / 1000];
        let mean_off = off.iter().sum::<f64>() / off.len() as f64 / mean;
        assert!(mean_off > 0.0, "{name}: nothing was merged");
        assert!(mean_off <= MEAN && high <= HIGH, "{name}: mean {mean_off:e} of the mean, 99.9th percentile {high}");
    }
}

#[test]
fn an_iris_as_wide_as_the_hinge_is_far_leaves_no_steps() {
    // The focus changes by more than a pixel of blur from pixel to pixel, and an empty sky surrounds the ball
    let is_ball = |x: i32, y: i32| (x - 160).pow(2) + (y - 100).pow(2) < 50 * 50;
    let color = Picture::from_fn(DISPLAY, |x, y| if is_ball(x, y) { [0.8, 0.4, 0.2, 1.0] } else { [0.0; 4] });
    let depth = Plane::from_fn(DISPLAY, |x, y| if is_ball(x, y) { 100.0 } else { f32::INFINITY });
    let frame = Frame::new(DISPLAY, vec![Layer::from_raw_depth(color, depth)]).unwrap();
    let (w, normal) = (DVec3::new(0.0, -1.0467, 0.004), DVec3::new(0.0, -0.0523, 0.9986));
    let lens = Camera {
        film: Film::from_fov(0.69, DISPLAY.width, DISPLAY.height).unwrap(),
        ..camera(w, normal, 1.25, ApertureShape::Disc)
    };
    let settings = GatherSettings { max_radius_px: Some(80.0), ..GatherSettings::default() };
    let [gathered, merged] =
        [Method::Gather(settings), Method::Merged(settings)].map(|method| filtered(&frame, &lens, &method));
    // Squares of merged pixels differ by 0.02; the plain sum over a lattice did by 0.3
    for (x, y) in DISPLAY.pixels() {
        let [gathered, merged] = [gathered.at(x, y)[3], merged.at(x, y)[3]];
        assert!((gathered - merged).abs() < 0.05, "({x}, {y}): alpha {gathered} and {merged}");
    }
}

#[test]
fn a_floor_whose_blur_grows_from_0_to_60_pixels_shows_no_seam_where_its_cells_change() {
    // No edge anywhere: each part of the floor is summed up in cells of its own size, from 1 to 4 pixels, and the parts are
    // added. White noise is the worst texture: measured were 2.2e-3 of the mean and 0.011 at most, tilted, and half of that
    // untilted
    const MEAN: f64 = 3e-3;
    const WORST: f32 = 0.02;
    const FURNACE: f32 = 1e-5;
    let display = PixelWindow::of_size(160, 200);
    let floor = |color: fn(i32, i32) -> f32| {
        let texture = move |x: i32, y: i32| color(x.div_euclid(8), y.div_euclid(8));
        Frame::new(display, vec![layer(display.grown(70, 70), texture, |_, y| 1.0 / (0.3 + 0.002 * y as f32))]).unwrap()
    };
    let lenses = [
        ("untilted", DVec3::new(0.0, 0.0, 0.2), ApertureShape::Disc),
        ("tilted", DVec3::new(0.05, 0.1, 0.2), ApertureShape::Disc),
        ("five blades", DVec3::new(0.0, 0.0, 0.2), ApertureShape::polygon(5, 0.1).unwrap()),
    ];
    for (name, w, shape) in lenses {
        let lens = over(display, &camera(w, DVec3::Z, 1.2, shape));
        let settings = GatherSettings { max_radius_px: Some(64.0), ..GatherSettings::default() };
        let frame = floor(|x, y| noise(x, y, 7));
        let [plain, merged] =
            [Method::Gather(settings), Method::Merged(settings)].map(|method| filtered(&frame, &lens, &method));
        let off: Vec<f32> = display.pixels().map(|(x, y)| (plain.at(x, y)[0] - merged.at(x, y)[0]).abs()).collect();
        let mean = off.iter().map(|&off| f64::from(off)).sum::<f64>() / off.len() as f64 / 0.5;
        let worst = off.iter().copied().fold(0.0, f32::max);
        assert!(mean > 0.0 && mean <= MEAN && worst <= WORST, "{name}: mean {mean:e} of the mean, worst {worst}");

        let furnace = filtered(&floor(|_, _| 1.0), &lens, &Method::Merged(settings));
        let off = display.pixels().map(|(x, y)| (furnace.at(x, y)[0] - 1.0).abs()).fold(0.0, f32::max);
        assert!(off <= FURNACE, "{name}: furnace off by {off:e}");
    }
}
