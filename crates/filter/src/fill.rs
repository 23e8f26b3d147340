//! The hidden background, as far as some point of the lens sees it: from the frame's layers, or else guessed from what is
//! visible beside it.
//!
//! Behind a near thing the far surface goes on. From each silhouette it is continued inwards, ring by ring, as far as some
//! point of the lens can look behind the edge: the difference of both blur radii. What hidden layers hold beyond that is
//! left out, since no lens point sees it and it could only leak. Where they hold nothing, the far surface is guessed: its
//! depth follows the plane that it has at the nearest silhouette pixel; its colour is an average around the mirror image of
//! the pixel beyond the silhouette, over an area that grows with the distance, since a texture is known less and less. The
//! colour never comes from the near thing.

use crate::{
    fragment::Fragment,
    surface::Surface,
    unmix::{Split, neighbours},
};

/// What limits the filling.
pub(crate) struct FillLimits {
    /// Blur radius in pixels of a unit of inverse depth.
    pub(crate) px: f32,
    /// The least jump of inverse depth that counts.
    pub(crate) jump: f32,
    /// The farthest from a silhouette, in pixels.
    pub(crate) reach: f32,
}

/// How far a guessed colour may be off, over the standard deviation of what it is the mean of: texture is coarser than the
/// places that are looked at. Fitted as said in `predicted.rs`.
const SPREAD: f32 = 3.0;

/// No silhouette.
const NONE: u32 = u32::MAX;

/// Removes from `hidden` what no lens point sees, and returns what is missing: the far surfaces of the near-side `splits`
/// continued behind `first`.
pub(crate) fn fill(first: &Surface, splits: &[Split], hidden: &mut [Surface], limits: &FillLimits) -> Vec<Fragment> {
    let window = first.window;
    let (width, height) = (window.width as i32, window.height as i32);
    let at = |i: usize| ((i as i32) % width, (i as i32) / width);
    let mut filled = Vec::new();

    // Start from the near side of every silhouette
    let mut source = vec![NONE; first.cover.len()];
    let mut ring: Vec<(usize, u32)> = Vec::new();
    for (k, split) in splits.iter().enumerate().filter(|(_, split)| split.is_near) {
        source[split.index] = k as u32;
        ring.push((split.index, k as u32));
        if !hidden.iter().any(|surface| surface.cover[split.index] > 0.0) {
            filled.push(Fragment {
                index: split.index as u32,
                cover: 1.0,
                is_before: false,
                inverse_depth: split.other_depth.max(0.0),
                slope: split.slope(split.other_depth),
                rgba: split.far,
                // Counted with the near surface's colour, from which it was told
                doubt: 0.0,
            });
        }
    }

    let mut offers: Vec<(usize, f32, u32)> = Vec::new();
    // No ring lies farther than the reach along any way, so that what a pixel takes depends on no more than that
    for _ in 0..limits.reach.ceil() as u32 {
        // Offer the silhouette that a filled pixel continues to the pixels around it
        offers.clear();
        for &(index, k) in &ring {
            let (x, y) = at(index);
            let split = &splits[k as usize];
            let (from_x, from_y) = at(split.index);
            for (dx, dy) in neighbours(1) {
                let (u, v) = (x + dx, y + dy);
                if u < 0 || v < 0 || u >= width || v >= height {
                    continue;
                }
                let i = (v * width + u) as usize;
                if source[i] != NONE {
                    continue;
                }
                let by = [(u - from_x) as f32, (v - from_y) as f32];
                let distance = (by[0] * by[0] + by[1] * by[1]).sqrt();
                let known =
                    hidden.iter().filter(|surface| surface.cover[i] > 0.0).map(|surface| surface.inverse_depth[i]);
                let behind = known.reduce(f32::min).unwrap_or_else(|| split.plane(by));
                let gap = first.inverse_depth[i] - behind;
                if gap > limits.jump && distance <= seen_behind(gap, limits) {
                    offers.push((i, distance, k));
                }
            }
        }

        if offers.is_empty() {
            break;
        }

        // Each takes the nearest
        offers.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
        offers.dedup_by_key(|offer| offer.0);
        ring.clear();
        for &(i, distance, k) in &offers {
            source[i] = k;
            ring.push((i, k));
            let mut is_known = false;
            for surface in hidden.iter_mut().filter(|surface| surface.cover[i] > 0.0) {
                is_known = true;
                if distance > seen_behind(first.inverse_depth[i] - surface.inverse_depth[i], limits) {
                    surface.cover[i] = 0.0;
                }
            }
            if !is_known {
                let (split, ((x, y), (from_x, from_y))) = (&splits[k as usize], (at(i), at(splits[k as usize].index)));
                filled.push(continued(first, split, i, [(x - from_x) as f32, (y - from_y) as f32], limits.jump));
            }
        }
    }

    // What no silhouette leads to is seen by no lens point
    for surface in hidden {
        surface
            .cover
            .iter_mut()
            .zip(&source)
            .filter(|&(_, &source)| source == NONE)
            .for_each(|(cover, _)| *cover = 0.0);
    }
    filled
}

/// How far behind an edge some lens point sees, in pixels, over a gap of inverse depth.
fn seen_behind(gap: f32, limits: &FillLimits) -> f32 {
    (gap * limits.px + 1.0).min(limits.reach)
}

impl Split {
    /// Inverse depth of the other surface's plane at an offset in pixels; no plane goes on beyond infinity.
    fn plane(&self, by: [f32; 2]) -> f32 {
        (self.other_depth + self.other_slope[0] * by[0] + self.other_slope[1] * by[1]).max(0.0)
    }

    /// The slope of that plane: none where it is infinitely far.
    fn slope(&self, inverse_depth: f32) -> [f32; 2] {
        if inverse_depth > 0.0 { self.other_slope } else { [0.0; 2] }
    }
}

/// The far surface of a silhouette pixel, continued to pixel `i` at an offset `by` from it: a mean around the mirrored
/// place.
fn continued(first: &Surface, split: &Split, i: usize, by: [f32; 2], jump: f32) -> Fragment {
    let window = first.window;
    let width = window.width as usize;
    let (x, y) = ((split.index % width) as f32, (split.index / width) as f32);
    let step = 0.25 * (by[0] * by[0] + by[1] * by[1]).sqrt();
    let square = |rgba: [f32; 4]| rgba.iter().map(|c| c * c).sum::<f32>();
    let (mut sum, mut squares, mut count) = (split.far, square(split.far), 1.0);
    // Every other place of five by five tells as much
    for (dx, dy) in neighbours(2).chain([(0, 0)]).filter(|(dx, dy)| (dx + dy) % 2 == 0) {
        let to = [step * dx as f32 - by[0], step * dy as f32 - by[1]];
        let (u, v) = (x + to[0] + 0.5, y + to[1] + 0.5);
        if u < 0.0 || v < 0.0 || u >= window.width as f32 || v >= window.height as f32 {
            continue;
        }
        let j = v as i32 as usize * width + u as i32 as usize;
        if (first.inverse_depth[j] - split.plane(to)).abs() <= jump && first.cover[j] > 0.99 {
            sum.iter_mut().zip(first.rgba[j]).for_each(|(sum, c)| *sum += c);
            squares += square(first.rgba[j]);
            count += 1.0;
        }
    }
    let rgba = sum.map(|c| c / count);
    let variance = (squares / count - square(rgba)).max(0.0) / 3.0;
    let inverse_depth = split.plane(by);
    Fragment {
        index: i as u32,
        cover: 1.0,
        is_before: false,
        inverse_depth,
        slope: split.slope(inverse_depth),
        rgba,
        doubt: SPREAD * variance.sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use rgbd::PixelWindow;

    use super::*;
    use crate::surface::Tame;

    #[test]
    fn nothing_is_guessed_behind_the_sky() {
        // A near thing, and the sky beside it
        const WIDTH: usize = 100;
        const NEAR: usize = 20;
        let inverse_depth: Vec<f32> = (0..WIDTH).map(|x| if x < NEAR { 0.5 } else { 0.0 }).collect();
        let first = Surface {
            window: PixelWindow::of_size(WIDTH as u32, 1),
            inverse_depth,
            rgba: vec![[1.0; 4]; WIDTH],
            cover: vec![1.0; WIDTH],
            doubt: Vec::new(),
            slopes: Vec::new(),
            tame: Tame::default(),
        };
        // Behind it goes on what falls back so steeply that it passes infinity at once, and the blur with it
        let split = Split {
            index: NEAR - 1,
            is_near: true,
            share: 0.5,
            near: [1.0; 4],
            far: [0.1, 0.1, 0.1, 1.0],
            doubt: 0.0,
            other_depth: 0.1,
            other_slope: [-0.2, 0.0],
        };
        let limits = FillLimits { px: 30.0, jump: 1.0 / 30.0, reach: 60.0 };
        let filled = fill(&first, &[split], &mut [], &limits);
        let beyond = filled.iter().filter(|fragment| fragment.index as usize >= NEAR).count();
        assert_eq!(beyond, 0, "{beyond} pixels of sky have something behind them");
        assert!(filled.len() >= 2, "{}: nothing is continued behind the near thing", filled.len());
        let is_sane = |fragment: &Fragment| fragment.inverse_depth > 0.0 || fragment.slope == [0.0; 2];
        assert!(filled.iter().all(is_sane), "a slope at infinity");
    }
}
