//! Ten pairs of pictures that differ in ten ways, for figures that other programs computed too.

use rgbd::{Picture, PixelWindow, Plane};

const WINDOW: PixelWindow = PixelWindow { x: 0, y: 0, width: 96, height: 54 };

/// Reference and candidate, both linear Rec. 709.
pub(crate) struct Pair {
    pub(crate) name: &'static str,
    pub(crate) reference: Picture,
    pub(crate) candidate: Picture,
}

/// All ten, always the same.
pub(crate) fn pairs() -> [Pair; 10] {
    let (scene, lamps) = (scene(), lamps());
    let pair = |name, reference: &Picture, candidate| Pair { name, reference: reference.clone(), candidate };
    [
        pair("noise", &scene, by_pixel(&scene, |[r, g, b], x, y| [r, g, b].map(|c| c + 0.1 * (hash(x, y, 1) - 0.5)))),
        pair("blur", &scene, blurred(&scene, 2)),
        pair("shift by a pixel", &scene, moved(&scene, 1)),
        pair("hue", &scene, by_pixel(&scene, |[r, g, b], _, _| [b, r, g])),
        pair("exposure", &scene, by_pixel(&scene, |rgb, _, _| rgb.map(|c| 1.25 * c))),
        pair("four bits", &scene, by_pixel(&scene, |rgb, _, _| rgb.map(|c| (15.0 * c).round() / 15.0))),
        pair("mirrored", &scene, Picture::from_fn(WINDOW, |x, y| scene.at(95 - x, y))),
        pair("lamps, blurred", &lamps, blurred(&lamps, 3)),
        pair(
            "fireflies in the dark",
            &by_pixel(&scene, |rgb, _, _| rgb.map(|c| 0.01 * c)),
            by_pixel(&scene, |rgb, x, y| rgb.map(|c| if hash(x, y, 2) > 0.99 { 30.0 } else { 0.01 * c })),
        ),
        Pair {
            name: "tilted lens, filtered and traced",
            reference: decoded(include_bytes!("../data/tilted_traced.png")),
            candidate: decoded(include_bytes!("../data/tilted_filtered.png")),
        },
    ]
}

/// A number in [0, 1) from a pixel and a seed.
fn hash(x: i32, y: i32, seed: u32) -> f32 {
    let mut h =
        (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77) ^ seed.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    (h ^ (h >> 15)) as f32 / 4_294_967_296.0
}

/// A red disc on a checkered floor under a sky that gets darker, with a textured corner.
fn scene() -> Picture {
    Picture::from_fn(WINDOW, |x, y| {
        let from_disc = ((x - 60) * (x - 60) + (y - 24) * (y - 24)) as f32;
        let is_even = (x / 6 + y / 6) % 2 == 0;
        let [r, g, b] = if from_disc < 200.0 {
            [0.8 - 0.002 * from_disc, 0.1, 0.08]
        } else if y < 20 {
            [0.3 + 0.01 * y as f32, 0.5 + 0.01 * y as f32, 0.9]
        } else if x < 24 {
            [0.2, 0.3 + 0.2 * hash(x, y, 7), 0.1]
        } else if is_even {
            [0.8, 0.8, 0.75]
        } else {
            [0.1, 0.1, 0.12]
        };
        [r, g, b, 1.0]
    })
}

/// The same in the evening, with lamps a thousand times as bright.
fn lamps() -> Picture {
    by_pixel(&scene(), |rgb, x, y| if x % 17 == 8 && y % 13 == 6 { [200.0, 150.0, 60.0] } else { rgb.map(|c| 0.2 * c) })
}

fn by_pixel(picture: &Picture, color: impl Fn([f32; 3], i32, i32) -> [f32; 3]) -> Picture {
    Picture::from_fn(picture.window(), |x, y| {
        let [r, g, b, a] = picture.at(x, y);
        let [r, g, b] = color([r, g, b], x, y).map(|c| c.max(0.0));
        [r, g, b, a]
    })
}

/// The mean over squares of 2 `reach` + 1 pixels, those at the border smaller.
fn blurred(picture: &Picture, reach: i32) -> Picture {
    Picture::from_fn(WINDOW, |x, y| {
        let around = (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (x + dx, y + dy)));
        let inside: Vec<_> = around.filter(|&(x, y)| WINDOW.contains(x, y)).map(|(x, y)| picture.at(x, y)).collect();
        [0, 1, 2, 3].map(|c| inside.iter().map(|rgba| rgba[c]).sum::<f32>() / inside.len() as f32)
    })
}

fn moved(picture: &Picture, by: i32) -> Picture {
    Picture::from_fn(WINDOW, |x, y| picture.at((x - by).max(0), y))
}

/// A PNG in linear light.
fn decoded(png: &[u8]) -> Picture {
    let image = image::load_from_memory(png).expect("a picture of this folder").to_rgb8();
    let window = PixelWindow::of_size(image.width(), image.height());
    let linear = |byte: u8| {
        let display = f64::from(byte) / 255.0;
        (if display <= 0.040_45 { display / 12.92 } else { ((display + 0.055) / 1.055).powf(2.4) }) as f32
    };
    let channel = |c: usize| Plane::from_values(window, image.pixels().map(|p| linear(p.0[c])).collect());
    let [r, g, b] = [0, 1, 2].map(|c| channel(c).expect("one value a pixel"));
    Picture::from_planes([r, g, b, Plane::filled(window, 1.0)]).expect("one window")
}
