//! The plain twin of the gather, for tests: one pixel, one neighbour and one number at a time.
//!
//! Rung 2 as [`gather`](crate::gather) describes it, without its machinery: no tiles, blocks or trees that find the
//! neighbours, no weights that are affine over a block, no vectors. Every piece of surface is looked at from every pixel,
//! with a kernel of the pixel's own; sums are f64.

use optics::Camera;
use rgbd::{Picture, PixelWindow};

use crate::{
    FrameView, cat_eye::Eye, gather::GatherRun, kernel::KernelTable, lens_map::PixelLens, prepare::Prepared,
    surface::pixel_q, tap::SLOPE_FROM, taps::SLAB_PX, view_lens::ViewLens,
};

/// A surface's part of a pixel.
struct Piece {
    is_first: bool,
    x: i32,
    y: i32,
    inverse_depth: f32,
    slope: [f32; 2],
    cover: f32,
    /// Premultiplied with the cover.
    rgba: [f32; 4],
}

/// What a piece gives to a pixel.
struct Given {
    is_first: bool,
    slab: i64,
    /// Share of the iris.
    share: f64,
    /// Its colour as if it filled its pixel.
    rgba: [f64; 4],
    /// The lens point through which it is seen, how far that is believed, and how sharply.
    point: [f64; 2],
    trust: f64,
    sharpness: f64,
}

/// Gathers `window`.
pub(crate) fn plain(view: &FrameView, camera: &Camera, run: &GatherRun, window: PixelWindow) -> Picture {
    let prepared = Prepared::new(view, camera, run.layers, run.fill_reach, run.sides);
    let table = KernelTable::of(camera);
    let pieces = pieces(&prepared);
    let lens = ViewLens { view, camera, model: run.model };
    let in_sight = lens.in_sight(&prepared.cells, run.max_radius.min(run.largest_radius));
    Picture::from_fn(window, |x, y| {
        let q = pixel_q(view, camera, x, y);
        let (lens, eye) = (PixelLens::new(camera, run.model, q), Eye::of(camera, q));
        let px = (camera.iris.radius() * camera.film.pixels_per_q().max_element()) as f32;
        let given =
            pieces.iter().filter_map(|piece| give(piece, (x, y), (&lens, eye.as_ref()), &table, px, run.max_radius));
        let mut given: Vec<Given> = given.collect();
        if !in_sight.at(x, y) {
            given.retain(|given| given.is_first);
            given.iter_mut().for_each(|given| given.slab = 0);
        }
        given.sort_by_key(|given| std::cmp::Reverse(given.slab));
        add_up(&given).unwrap_or_else(|| {
            let first = &prepared.first;
            if !first.window.contains(x, y) {
                return [0.0; 4];
            }
            let i = first.window.index(x, y);
            first.rgba[i].map(|c| c / first.cover[i])
        })
    })
}

fn pieces(prepared: &Prepared) -> Vec<Piece> {
    let (first, window) = (&prepared.first, prepared.window());
    let place = |i: usize| (window.x + i as i32 % window.width as i32, window.y + i as i32 / window.width as i32);
    let of_first = (0..window.area()).filter(|&i| first.cover[i] > 0.0).map(|i| {
        let (x, y) = place(i);
        let (inverse_depth, slope) = (first.inverse_depth[i], first.slope(i, i % window.width as usize));
        Piece { is_first: true, x, y, inverse_depth, slope, cover: first.cover[i], rgba: first.rgba[i] }
    });
    let of_fragments = prepared.fragments.iter().map(|f| {
        let (x, y) = place(f.index as usize);
        Piece { is_first: false, x, y, inverse_depth: f.inverse_depth, slope: f.slope, cover: f.cover, rgba: f.rgba }
    });
    of_first.chain(of_fragments).collect()
}

/// What a piece gives to the pixel at (x, y), if anything.
fn give(
    piece: &Piece,
    (x, y): (i32, i32),
    (lens, eye): (&PixelLens, Option<&Eye>),
    table: &KernelTable,
    px: f32,
    max_radius: f32,
) -> Option<Given> {
    let (dx, dy) = ((piece.x - x) as f32, (piece.y - y) as f32);
    let defocus = lens.scale * (piece.inverse_depth - lens.focus);
    let radius = defocus.abs().min(max_radius);
    if dx.abs().max(dy.abs()) > 2.0 * lens.stretch() * radius + 2.0 {
        return None;
    }

    // The weight of the pixel in the footprint
    let (kernel, _) = table.with_slope(radius);
    let offset = lens.iris_offset(dx, dy, defocus, radius);
    let weight = match eye {
        Some(eye) => eye.weight(table, offset, radius, &kernel),
        None => table.weight(offset, radius, &kernel),
    };
    let weight = piece.cover * weight;
    if weight <= 0.0 {
        return None;
    }

    // A sloped surface counts by the part of the iris it fills
    let trust = (radius - SLOPE_FROM).clamp(0.0, 1.0);
    let to_lens = if trust > 0.0 { defocus.signum() / defocus.abs().max(SLOPE_FROM) } else { 0.0 };
    let rise = lens.scale * (piece.slope[0] * dx + piece.slope[1] * dy);
    let slope = (1.0 - trust * rise * to_lens).clamp(0.5, 2.0);
    let point = lens.unskewed(dx, dy).map(|d| d * to_lens);
    let point = eye.map_or(point, |eye| eye.on_disc(point));
    Some(Given {
        is_first: piece.is_first,
        slab: (piece.inverse_depth * px / SLAB_PX).floor() as i64,
        share: f64::from(weight * slope),
        rgba: piece.rgba.map(|c| f64::from(c / piece.cover)),
        point: point.map(f64::from),
        trust: f64::from(trust),
        sharpness: f64::from((0.5 * radius).clamp(0.5, 4.0)),
    })
}

/// Adds up what a pixel is given, nearest slab first, until its iris is full; `None` if it is given nothing.
fn add_up(given: &[Given]) -> Option<[f32; 4]> {
    let (mut full, mut rgba) = (0.0, [0.0; 4]);
    // Share and moment of the lens points that nearer slabs hide; the last slab hides only what does not touch it
    let (mut seen, mut last, mut last_slab) = ([0.0; 3], [0.0; 3], i64::MAX);
    for slab in given.chunk_by(|a, b| a.slab == b.slab) {
        if last_slab.saturating_sub(slab[0].slab) > 1 {
            (0..3).for_each(|i| seen[i] += std::mem::take(&mut last[i]));
        }

        // Leave out what is seen through hidden lens points
        let (mut sum, mut color, mut moment) = (0.0, [0.0; 4], [0.0; 2]);
        for tap in slab {
            let share = tap.share * open_share(seen, tap);
            sum += share;
            (0..4).for_each(|c| color[c] += share * tap.rgba[c]);
            (0..2).for_each(|i| moment[i] += share * tap.trust * tap.point[i]);
        }
        if sum <= 0.0 {
            continue;
        }

        // Let it in as far as the iris is open
        let taken = f64::min(sum, 1.0 - full);
        let share = taken / sum;
        full += taken;
        (0..4).for_each(|c| rgba[c] += share * color[c]);
        (0..3).for_each(|i| seen[i] += last[i]);
        last = [taken, share * moment[0], share * moment[1]];
        last_slab = slab[0].slab;
    }
    (full > 0.0).then(|| rgba.map(|c| (c / full) as f32))
}

/// How far a tap is seen past the half plane of lens points that nearer slabs hide.
fn open_share([share, x, y]: [f64; 3], tap: &Given) -> f64 {
    if share <= 1e-4 {
        return 1.0;
    }
    let length = x.hypot(y);
    let direction = [x, y].map(|v| v / length.max(1e-12));
    let open = (1.0 - 2.0 * share).clamp(-1.0, 1.0);
    let edge = open * (1.0 - std::f64::consts::FRAC_PI_4) * open * open + open * std::f64::consts::FRAC_PI_4;
    let moment = (1.0 - edge * edge).max(0.0).powf(1.5) * 2.0 / (3.0 * std::f64::consts::PI);
    let strength = (length / moment.max(1e-3)).min(1.0) * tap.trust;
    let along = tap.point[0] * direction[0] + tap.point[1] * direction[1];
    let open = ((edge - along) * tap.sharpness + 0.5).clamp(0.0, 1.0);
    1.0 + strength * (open - 1.0)
}

#[cfg(test)]
mod tests {
    use fearless_simd::Level;
    use glam::{DVec2, DVec3};
    use optics::{ApertureShape, Film, Focus, Iris, KernelModel, Pose};
    use rgbd::{Frame, Layer, Plane, Silent};

    use super::*;
    use crate::{Sides, gather::gather};

    const DISPLAY: PixelWindow = PixelWindow { x: -5, y: 3, width: 61, height: 43 };

    /// A cheap, repeatable number in [0, 1) from a pixel.
    fn noise(x: i32, y: i32, salt: u32) -> f32 {
        let mut h = (x as u32).wrapping_mul(0x9E37_79B9) ^ (y as u32).wrapping_mul(0x85EB_CA6B) ^ salt;
        h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
        h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
        (h >> 8) as f32 / (1 << 24) as f32
    }

    /// Noise on sloped patches at depths of 1 to 8, with sky and holes; a hidden layer here and there.
    fn rough_frame() -> Frame {
        let data = DISPLAY.grown(8, 5);
        let patch = |x: i32, y: i32, salt: u32| noise(x.div_euclid(9), y.div_euclid(7), salt);
        let color = |salt| move |x, y| [noise(x, y, salt), noise(x, y, salt + 1), noise(x, y, salt + 2), 1.0];
        let depth = |x, y| match patch(x, y, 1) {
            n if n < 0.1 => f32::INFINITY,
            n if n < 0.2 => f32::NAN,
            n => 1.0 / ((1.0 + 7.0 * n).recip() + 0.002 * (x as f32 * patch(x, y, 2) + y as f32 * patch(x, y, 3))),
        };
        let front = Layer::from_raw_depth(Picture::from_fn(data, color(10)), Plane::from_fn(data, depth));
        let is_there = |x, y| patch(x, y, 4) < 0.4;
        let hidden_color = |x, y| if is_there(x, y) { color(20)(x, y) } else { [0.0; 4] };
        let hidden_depth = |x, y| if is_there(x, y) { 9.0 } else { f32::NAN };
        let hidden = Layer::from_raw_depth(Picture::from_fn(data, hidden_color), Plane::from_fn(data, hidden_depth));
        Frame::new(DISPLAY, vec![front, hidden]).unwrap()
    }

    fn camera(w: DVec3, normal: DVec3, radius: f64, shape: ApertureShape) -> Camera {
        let half = DVec2::new(f64::from(DISPLAY.width), f64::from(DISPLAY.height)) / 200.0;
        Camera {
            pose: Pose::IDENTITY,
            film: Film::new(-half, half, DISPLAY.width, DISPLAY.height).unwrap(),
            focus: Focus::new(w).unwrap(),
            iris: Iris::new(normal, radius, shape).unwrap(),
        }
    }

    fn with_eye(camera: Camera) -> Camera {
        camera.with_cat_eye(0.8).unwrap()
    }

    fn cases() -> Vec<(&'static str, Camera, KernelModel)> {
        let pentagon = ApertureShape::polygon(5, 0.3).unwrap();
        let (upright, leaning) = (DVec3::Z, DVec3::new(0.1, -0.15, 1.0));
        let (level, tilted, steep) =
            (DVec3::new(0.0, 0.0, 0.4), DVec3::new(0.05, -0.2, 0.4), DVec3::new(0.6, -1.2, 0.3));
        vec![
            ("level disc", camera(level, upright, 0.2, ApertureShape::Disc), KernelModel::Disc),
            ("level pentagon", camera(level, upright, 0.2, pentagon), KernelModel::Disc),
            ("tilted disc", camera(tilted, upright, 0.2, ApertureShape::Disc), KernelModel::Disc),
            ("tilted ellipse", camera(tilted, leaning, 0.2, ApertureShape::Disc), KernelModel::Ellipse),
            ("tilted pentagon", camera(tilted, leaning, 0.15, pentagon), KernelModel::Exact),
            ("tilted exact", camera(tilted, leaning, 0.15, ApertureShape::Disc), KernelModel::Exact),
            ("steep disc", camera(steep, upright, 0.15, ApertureShape::Disc), KernelModel::Disc),
            ("level cat's eye", with_eye(camera(level, upright, 0.2, ApertureShape::Disc)), KernelModel::Disc),
            ("tilted cat's eye", with_eye(camera(tilted, leaning, 0.15, pentagon)), KernelModel::Exact),
            ("steep exact", camera(steep, leaning, 0.1, pentagon), KernelModel::Exact),
        ]
    }

    fn run(model: KernelModel, level: Level) -> GatherRun {
        GatherRun {
            model,
            max_radius: 40.0,
            largest_radius: 40.0,
            layers: 2,
            sides: Sides::Both,
            fill_reach: 30.0,
            merge: false,
            level,
            doubt: false,
        }
    }

    /// Each level that this machine has.
    fn levels() -> Vec<Level> {
        let best = Level::new();
        let mut levels = vec![best, Level::baseline()];
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            levels.extend(best.as_sse2().map(Level::Sse2));
            levels.extend(best.as_sse4_2().map(Level::Sse4_2));
            levels.extend(best.as_avx2().map(Level::Avx2));
            levels.extend(best.as_avx512().map(Level::Avx512));
        }
        levels
    }

    /// Mean, 99th percentile and largest of the absolute differences.
    fn differences(a: &Picture, b: &Picture) -> [f32; 3] {
        let values =
            |picture: &Picture| -> Vec<f32> { picture.planes().iter().flat_map(Plane::values).copied().collect() };
        let mut off: Vec<f32> = values(a).iter().zip(values(b)).map(|(a, b)| (a - b).abs()).collect();
        off.sort_by(f32::total_cmp);
        [off.iter().sum::<f32>() / off.len() as f32, off[off.len() * 99 / 100], off[off.len() - 1]]
    }

    #[test]
    fn vectors_of_every_level_gather_what_the_plain_twin_does() {
        // Rounding of some hundred f32 terms, where the focus is the same for a whole block
        const ROUNDING: f32 = 2e-6;
        // Where it is not, kernels are affine in it as long as it changes by no more than 8 % of the blur radius, which is
        // 2 % of the weight; what tells lens points and slopes apart is that of the block's centre (of 8 x 2 pixels, over
        // which the blur of the steepest case here changes by 0.8 px). White noise on white steps of depth shows all of it
        const MEAN: f32 = 1e-3;
        const HIGH: f32 = 0.01;
        const WORST: f32 = 0.1;
        let frame = rough_frame();
        let view = FrameView::whole(&frame);
        for (name, camera, model) in cases() {
            let wanted = plain(&view, &camera, &run(model, Level::new()), DISPLAY);
            let best = gather(&view, &camera, &run(model, Level::new()), DISPLAY, &Silent).unwrap().picture;
            for level in levels() {
                let found = gather(&view, &camera, &run(model, level), DISPLAY, &Silent).unwrap().picture;
                let [mean, high, worst] = differences(&found, &wanted);
                let what = format!("{name}, {level:?}: mean {mean:e}, 99th percentile {high:e}, worst {worst:e}");
                if camera.focus.w().truncate() == DVec2::ZERO {
                    assert!(worst <= ROUNDING, "{what}");
                } else {
                    assert!(mean <= MEAN && high <= HIGH && worst <= WORST, "{what}");
                }
                // Levels differ by rounding alone, whatever the lens; merged ones too
                assert!(differences(&found, &best)[2] <= ROUNDING, "{name}: {level:?} is not {:?}", Level::new());
                let merged = |level| {
                    let run = GatherRun { merge: true, ..run(model, level) };
                    gather(&view, &camera, &run, DISPLAY, &Silent).unwrap().picture
                };
                let off = differences(&merged(level), &merged(Level::new()))[2];
                assert!(off <= ROUNDING, "{name}, merged: {level:?} is not {:?}: {off:e}", Level::new());
            }
        }
    }

    #[test]
    fn no_level_depends_on_the_number_of_threads() {
        let frame = rough_frame();
        let view = FrameView::whole(&frame);
        for (name, camera, model) in cases() {
            for (level, merge) in levels().into_iter().flat_map(|level| [(level, false), (level, true)]) {
                let run = GatherRun { merge, ..run(model, level) };
                let [one, three] = [1, 3].map(|threads| {
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                    pool.install(|| gather(&view, &camera, &run, DISPLAY, &Silent).unwrap().picture)
                });
                assert!(one == three, "{name}, {level:?}, merged {merge}");
            }
        }
    }
}
