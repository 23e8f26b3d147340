//! Depth made worse, the same way at every step.

use rgbd::{Frame, Layer, PixelWindow, Plane};

/// The frame with each layer's depth replaced by a function of layer, pixel and depth; unknown depth stays unknown.
fn with_depth(frame: &Frame, depth: impl Fn(usize, i32, i32, f32) -> f32) -> Frame {
    let layers = frame.layers().iter().enumerate().map(|(index, layer)| {
        let at =
            |x: i32, y: i32| if layer.known.at(x, y) { depth(index, x, y, layer.depth.at(x, y)) } else { f32::NAN };
        Layer::from_raw_depth(layer.color.clone(), Plane::from_fn(layer.window(), at))
    });
    rebuilt(frame, layers.collect())
}

/// A frame of other layers over the same windows.
fn rebuilt(frame: &Frame, layers: Vec<Layer>) -> Frame {
    let mut spoilt = Frame::new(frame.display, layers).expect("layers of one window, unknown where depth is bad");
    spoilt.camera = frame.camera;
    spoilt
}

/// A share of the first layer's pixels, in blocks of 2 x 2, holds 0, a negative number or NaN in place of its depth.
pub(super) fn with_holes(frame: &Frame, share: f64) -> Frame {
    with_blocks(frame, share, |chance| [0.0, -1.0, f32::NAN][(3.0 * chance) as usize])
}

/// A share of the first layer's pixels, in blocks of 2 x 2, is infinitely far.
pub(super) fn with_sky(frame: &Frame, share: f64) -> Frame {
    with_blocks(frame, share, |_| f32::INFINITY)
}

/// A share of the first layer's blocks of 2 x 2 pixels with a depth by chance (0 to 1); the larger the share, the more of
/// them, and none comes back.
fn with_blocks(frame: &Frame, share: f64, value: impl Fn(f64) -> f32) -> Frame {
    with_depth(frame, |layer, x, y, depth| {
        let (u, v) = (x.div_euclid(2), y.div_euclid(2));
        if layer > 0 || uniform(u, v, 0) >= share { depth } else { value(uniform(u, v, 1)) }
    })
}

/// Depth times 1 + `amount` times a normal deviate that stays the same at each pixel.
pub(super) fn with_noise(frame: &Frame, amount: f64) -> Frame {
    with_depth(frame, |layer, x, y, depth| {
        // Four uniform numbers make one that is nearly normal, of variance 1/3
        let sum: f64 = (0..4).map(|k| uniform(x, y, 16 * layer as u32 + k) - 0.5).sum();
        let factor = (1.0 + amount * sum * 3.0_f64.sqrt()).max(0.01);
        (f64::from(depth) * factor) as f32
    })
}

/// Inverse depth in steps of a share of its range over the frame; the sky stays.
pub(super) fn quantised(frame: &Frame, step: f64) -> Frame {
    let known = frame.layers().iter().flat_map(|layer| {
        let depths = layer.depth.values().iter().zip(layer.known.bits());
        depths.filter(|&(&depth, &known)| known && depth.is_finite()).map(|(&depth, _)| 1.0 / f64::from(depth))
    });
    let (least, most) = known.fold((f64::INFINITY, 0.0_f64), |(a, b), s| (a.min(s), b.max(s)));
    let step = step * (most - least);
    with_depth(frame, |_, _, _, depth| {
        if depth.is_infinite() || step <= 0.0 {
            return depth;
        }
        let inverse = least + ((1.0 / f64::from(depth) - least) / step).round() * step;
        (1.0 / inverse) as f32
    })
}

/// Depth as half floats hold it: 11 significant bits.
pub(super) fn as_half(frame: &Frame) -> Frame {
    with_depth(frame, |_, _, _, depth| {
        const LOST: u32 = 13; // of the 23 bits that follow the leading one
        let bits = depth.to_bits();
        if depth.is_finite() { f32::from_bits((bits + (1 << (LOST - 1))) & !((1 << LOST) - 1)) } else { depth }
    })
}

/// Depth of the pixel (dx, dy) away.
pub(super) fn moved(frame: &Frame, (dx, dy): (i32, i32)) -> Frame {
    let layers = frame.layers().iter().map(|layer| {
        let from = |x: i32, y: i32| clamped(layer.window(), x + dx, y + dy);
        let depth = |x: i32, y: i32| {
            let (x, y) = from(x, y);
            if layer.known.at(x, y) { layer.depth.at(x, y) } else { f32::NAN }
        };
        Layer::from_raw_depth(layer.color.clone(), Plane::from_fn(layer.window(), depth))
    });
    rebuilt(frame, layers.collect())
}

/// The pixel of a window that is nearest to (x, y).
fn clamped(window: PixelWindow, x: i32, y: i32) -> (i32, i32) {
    (x.clamp(window.x, window.x_end() - 1), y.clamp(window.y, window.y_end() - 1))
}

/// A repeatable number in [0, 1) from a pixel.
fn uniform(x: i32, y: i32, salt: u32) -> f64 {
    let mut h =
        (x as u32).wrapping_mul(0x9E37_79B9) ^ (y as u32).wrapping_mul(0x85EB_CA6B) ^ salt.wrapping_mul(0xC2B2_AE35);
    h = (h ^ (h >> 15)).wrapping_mul(0x2C1B_3C6D);
    h = (h ^ (h >> 12)).wrapping_mul(0x297A_2D39);
    h ^= h >> 15;
    f64::from(h) / 4_294_967_296.0
}

#[cfg(test)]
mod tests {
    use rgbd::Picture;

    use super::*;

    fn ramp() -> Frame {
        let window = PixelWindow::of_size(64, 64);
        let color = Picture::filled(window, [0.5, 0.5, 0.5, 1.0]);
        let depth = Plane::from_fn(window, |x, y| if y == 0 { f32::INFINITY } else { 1.0 + 0.1 * x as f32 });
        Frame::new(window, vec![Layer::from_raw_depth(color, depth)]).unwrap()
    }

    #[test]
    fn noise_has_the_deviation_that_was_asked_for() {
        let (clean, noisy) = (ramp(), with_noise(&ramp(), 0.05));
        let window = PixelWindow::from_corners(0, 1, 64, 64);
        let relative = |(x, y)| f64::from(noisy.layers()[0].depth.at(x, y) / clean.layers()[0].depth.at(x, y)) - 1.0;
        let variance = window.pixels().map(|p| relative(p).powi(2)).sum::<f64>() / window.area() as f64;
        // 4032 deviates: 3 standard errors of their own deviation are 3.4 %
        assert!((variance.sqrt() / 0.05 - 1.0).abs() < 0.034, "{}", variance.sqrt());
        assert!(noisy.layers()[0].depth.at(3, 0).is_infinite(), "the sky stays");
    }

    #[test]
    fn holes_grow_and_none_closes() {
        let unknown = |share| with_holes(&ramp(), share).layers()[0].known.clone();
        let (few, many) = (unknown(0.1), unknown(0.3));
        assert!(few.count() > many.count());
        assert!(few.bits().iter().zip(many.bits()).all(|(few, many)| *few || !*many));
    }

    #[test]
    fn halves_and_levels_are_near() {
        let half = as_half(&ramp());
        let levels = quantised(&ramp(), 1.0 / 255.0);
        for (x, y) in PixelWindow::from_corners(0, 1, 64, 64).pixels() {
            let (z, h, l) =
                (ramp().layers()[0].depth.at(x, y), half.layers()[0].depth.at(x, y), levels.layers()[0].depth.at(x, y));
            assert!((h / z - 1.0).abs() <= 1.0 / 2048.0, "{z} as {h}");
            assert!((1.0 / l - 1.0 / z).abs() <= 0.501 / 255.0, "{z} as {l}");
        }
    }
}
