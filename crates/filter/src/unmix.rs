//! Anti-aliased colour over one depth per pixel, taken apart at silhouettes.
//!
//! A pixel on a silhouette holds colour of two surfaces and the depth of one. Blurred with that depth it leaves a rim: of
//! the background's colour around a near thing, or of the near thing's on the background. So at every jump of depth the
//! colour C = a N + (1 - a) F is split into the near surface's N and the far surface's F, with pure pixels nearby as the
//! guess of both, and a, the share that the near one covers, by projection. Where both look alike or are textured the
//! projection tells little, and the share of near pixels around weighs more. The pixel's own depth says which of both
//! covers its centre, and so at least half of it. What the guess leaves over is given to both in the way that changes them
//! least, so that the two together are the pixel's colour exactly.
//!
//! Where the frame knows the [`Rest`] of its pixels nothing has to be guessed, and things thinner than a pixel are found.

use rayon::prelude::*;
use rgbd::Rest;

use crate::{
    cells::Cells,
    surface::{Surface, rest_at},
};

/// How far pure pixels are looked for.
pub(crate) const UNMIX_REACH: i32 = 3;

/// A jump of depth counts from this many pixels of blur radius.
const LEAST_JUMP_PX: f32 = 1.0;

/// Shares nearer to 0 or 1 than this are taken as that.
const PURE: f32 = 0.02;

/// Variance of the weights by distance around a silhouette pixel, in pixels: its neighbours count by far the most.
const NEARNESS: f32 = 0.7;

/// How far both colours may be off, over what they leave of the pixel's colour before they are bent to give it, and over
/// their difference times the smaller of both shares. Fitted as said in `predicted.rs`: what is left over foretells the
/// error better than the variance of the pure pixels does.
const MISFIT: f32 = 0.72;
const MIXED: f32 = 0.36;

/// The same where shares and colours are known: what is left is what kernels make of a part of a pixel. Two thirds of the
/// above, as is the error at the edges of the project's shots.
const MIXED_KNOWN: f32 = 0.24;

/// A variance of colour that is always allowed for, so that equal colours do not divide by 0.
const LEAST_VARIANCE: f32 = 1e-3;

/// A silhouette pixel taken apart.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Split {
    pub(crate) index: usize,
    /// Whether the pixel's own depth is the near surface's.
    pub(crate) is_near: bool,
    /// What the near surface covers of the pixel, 0 to 1.
    pub(crate) share: f32,
    /// Colours of both surfaces, as if each filled the pixel.
    pub(crate) near: [f32; 4],
    pub(crate) far: [f32; 4],
    /// How far those colours may be off, root mean square over R, G and B.
    pub(crate) doubt: f32,
    /// Inverse depth and slope of the surface that the pixel's own depth does not tell.
    pub(crate) other_depth: f32,
    pub(crate) other_slope: [f32; 2],
}

/// The least jump of inverse depth that counts; `px` is the blur radius in pixels of a unit of inverse depth.
pub(crate) fn least_jump(px: f32) -> f32 {
    LEAST_JUMP_PX / px.max(f32::MIN_POSITIVE)
}

/// The silhouette pixels of the first surface, row by row; `rest` tells of what they are mixed where that is known, `behind`
/// holds what hidden layers know there.
pub(crate) fn splits(first: &Surface, cells: &Cells, rest: Option<Rest>, behind: &[Surface], jump: f32) -> Vec<Split> {
    let window = first.window;
    let width = window.width as usize;

    // Find out on which side of a jump each pixel lies
    let mut sides = vec![Side::Pure; window.area()];
    sides.par_chunks_mut(width).enumerate().for_each(|(row, sides)| {
        mark_sides(first, cells, row, jump, sides);
        if let Some(rest) = rest {
            mark_mixed(first, cells, rest, row, jump, sides);
        }
    });

    let nearness = std::array::from_fn(|squared| (-0.5 * squared as f32 / NEARNESS).exp());
    let splitter = Splitter { first, behind, rest, sides: &sides, jump, nearness };
    let rows: Vec<Vec<Split>> = (0..window.height as usize)
        .into_par_iter()
        .map(|row| {
            let mixed = (row * width..(row + 1) * width).filter(|&i| sides[i] != Side::Pure);
            mixed.filter_map(|i| splitter.split(i)).collect()
        })
        .collect();
    rows.concat()
}

/// Root mean square over R, G and B.
fn rms([r, g, b, _]: [f32; 4]) -> f32 {
    ((r * r + g * g + b * b) / 3.0).sqrt()
}

/// No alpha above 1 unless the pixel itself has one.
fn opaque_at_most([r, g, b, a]: [f32; 4], own: f32) -> [f32; 4] {
    [r, g, b, a.min(own.max(1.0))]
}

/// Where a pixel lies beside a jump of depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    /// No jump beside it.
    Pure,
    /// Something farther lies beside it, nothing nearer.
    Near,
    /// Something nearer lies beside it.
    Far,
}

/// The sides of one row's pixels.
fn mark_sides(surface: &Surface, cells: &Cells, row: usize, jump: f32, sides: &mut [Side]) {
    let width = surface.window.width as usize;
    let last_row = surface.window.height as usize - 1;
    let depth = |row: usize| &surface.inverse_depth[row * width..(row + 1) * width];
    let (above, here, below) = (depth(row.saturating_sub(1)), depth(row), depth((row + 1).min(last_row)));
    for x in cells.edges_of_row(row).flatten() {
        let (left, right) = (x.saturating_sub(1), (x + 1).min(width - 1));
        let around =
            [above[left], above[x], above[right], here[left], here[right], below[left], below[x], below[right]];
        let (low, high) = around.iter().fold((here[x], here[x]), |(low, high), &s| (low.min(s), high.max(s)));
        // Most pixels end here
        if high - here[x] <= jump && here[x] - low <= jump {
            continue;
        }
        let [dx, dy] = surface.slope(row * width + x, x);
        let rise = [-dx - dy, -dy, dx - dy, -dx, dx, dy - dx, dy, dx + dy];
        for (there, rise) in around.into_iter().zip(rise) {
            let step = there - here[x] - rise;
            if step > jump && there > here[x] {
                sides[x] = Side::Far;
                break;
            }
            if step < -jump && there < here[x] {
                sides[x] = Side::Near;
            }
        }
    }
}

/// The sides of one row's pixels that are known to be mixed.
fn mark_mixed(surface: &Surface, cells: &Cells, rest: Rest, row: usize, jump: f32, sides: &mut [Side]) {
    let window = surface.window;
    let here = &surface.inverse_depth[row * window.width as usize..];
    for x in cells.edges_of_row(row).flatten() {
        match rest_at(rest, window.x + x as i32, window.y + row as i32).map(|(inverse, _)| inverse - here[x]) {
            Some(step) if step > jump => sides[x] = Side::Far,
            Some(step) if step < -jump => sides[x] = Side::Near,
            _ => (),
        }
    }
}

/// The offsets of the pixels around one, row by row.
pub(crate) fn neighbours(reach: i32) -> impl Iterator<Item = (i32, i32)> {
    (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| (dx, dy))).filter(|&at| at != (0, 0))
}

/// A guess of one surface's colour and depth at a pixel, from pixels around.
#[derive(Clone, Copy, Default)]
struct Guess {
    weight: f32,
    rgba: [f32; 4],
    /// Mean square while it is summed up, then the variance over all channels.
    variance: f32,
    depth: f32,
    /// The nearest inverse depth that it is made of.
    nearest: f32,
    slope: [f32; 2],
}

impl Guess {
    /// Adds a pixel at an offset.
    fn add(&mut self, weight: f32, rgba: [f32; 4], depth: f32, slope: [f32; 2], (dx, dy): (i32, i32)) {
        self.nearest = if self.weight > 0.0 { self.nearest.max(depth) } else { depth };
        let depth = depth - slope[0] * dx as f32 - slope[1] * dy as f32;
        self.weight += weight;
        self.rgba.iter_mut().zip(rgba).for_each(|(sum, c)| *sum += weight * c);
        self.variance += weight * rgba.iter().map(|c| c * c).sum::<f32>();
        self.depth += weight * depth;
        self.slope.iter_mut().zip(slope).for_each(|(sum, s)| *sum += weight * s);
    }

    fn mean(&self) -> Option<Self> {
        let scale = (self.weight > 0.0).then(|| 1.0 / self.weight)?;
        let rgba = self.rgba.map(|c| c * scale);
        let variance = (self.variance * scale - rgba.iter().map(|c| c * c).sum::<f32>()).max(0.0);
        let slope = self.slope.map(|s| s * scale);
        // A guess is no nearer than what it is made of, so that nothing is blurred more than the frame's depths tell
        let depth = (self.depth * scale).min(self.nearest);
        Some(Self { rgba, variance, depth, slope, ..*self })
    }
}

struct Splitter<'a> {
    first: &'a Surface,
    behind: &'a [Surface],
    rest: Option<Rest<'a>>,
    sides: &'a [Side],
    jump: f32,
    /// Weights by squared distance.
    nearness: [f32; (2 * UNMIX_REACH * UNMIX_REACH + 1) as usize],
}

impl Splitter<'_> {
    fn split(&self, index: usize) -> Option<Split> {
        let (side, rgba) = (self.sides[index], self.first.rgba[index]);
        let is_near = side == Side::Near;
        let (own, mut other, tent) = self.guesses(index);
        if let Some(rest) = self.rest {
            return self.known(index, is_near, rest, other);
        }

        // What a hidden layer knows of the far side is worth more than any guess
        if let (true, Some(hidden)) = (is_near, self.hidden(index)) {
            other = Some(Guess { variance: 0.5 * other.map_or(0.0, |guess| guess.variance), ..hidden });
        }
        let other = other?;
        let own = own.unwrap_or(Guess { rgba, ..Guess::default() });
        let (near, far) = if is_near { (own.rgba, other.rgba) } else { (other.rgba, own.rgba) };

        // Project the colour onto the line between them
        let step: [f32; 4] = [0, 1, 2, 3].map(|c| near[c] - far[c]);
        let square = step.iter().map(|s| s * s).sum::<f32>();
        let along = (0..4).map(|c| (rgba[c] - far[c]) * step[c]).sum::<f32>();
        let variance = LEAST_VARIANCE + own.variance + other.variance;
        let guess = if is_near { tent } else { 1.0 - tent };
        let (low, high) = if is_near { (0.5, 1.0) } else { (0.0, 0.5) };
        let share = ((along + guess * variance) / (square + variance)).clamp(low, high);
        let share = if share < PURE {
            0.0
        } else if share > 1.0 - PURE {
            1.0
        } else {
            share
        };

        let open = 1.0 - share;
        let rest = [0, 1, 2, 3].map(|c| rgba[c] - share * near[c] - open * far[c]);
        let doubt = (MISFIT * rms(rest)).hypot(MIXED * share.min(open) * rms(step));

        // Give what is left over to both in the way that changes them least
        let norm = share * share + open * open;
        let both = [0, 1, 2, 3].map(|c| {
            let rest = rest[c] / norm;
            match (near[c] + share * rest, far[c] + open * rest) {
                // No surface is darker than black; the other one then holds all
                (near, far) if near < 0.0 && rgba[c] >= 0.0 => (0.0, if open > 0.0 { rgba[c] / open } else { far }),
                (near, far) if far < 0.0 && rgba[c] >= 0.0 => (if share > 0.0 { rgba[c] / share } else { near }, 0.0),
                both => both,
            }
        });
        Some(Split {
            index,
            is_near,
            share,
            near: opaque_at_most(both.map(|(near, _)| near), rgba[3]),
            far: opaque_at_most(both.map(|(_, far)| far), rgba[3]),
            doubt,
            other_depth: other.depth,
            other_slope: other.slope,
        })
    }

    /// A silhouette pixel whose rest is known; a guess of the other surface where it is all its own.
    fn known(&self, index: usize, is_near: bool, rest: Rest, guess: Option<Guess>) -> Option<Split> {
        let window = self.first.window;
        let (x, y) = ((index % window.width as usize) as i32, (index / window.width as usize) as i32);
        let (own_depth, rgba) = (self.first.inverse_depth[index], self.first.rgba[index]);
        let is_other = |&(inverse, rgba): &(f32, [f32; 4])| {
            let step = inverse - own_depth;
            rgba[3] >= PURE && if is_near { step < -self.jump } else { step > self.jump }
        };
        let hidden = if is_near { self.hidden(index) } else { None };
        let beside = hidden.or(guess);
        let Some((other_depth, rest)) = rest_at(rest, window.x + x, window.y + y).filter(is_other) else {
            let beside = beside?;
            let (near, far) = if is_near { (rgba, beside.rgba) } else { (beside.rgba, rgba) };
            let (share, other_depth, other_slope) = (f32::from(u8::from(is_near)), beside.depth, beside.slope);
            return Some(Split { index, is_near, share, near, far, doubt: 0.0, other_depth, other_slope });
        };
        let same = beside.filter(|beside| (beside.depth - other_depth).abs() <= self.jump);
        // A part holds no more light than the whole, and no less than none, whatever a file says
        let rest: [f32; 4] =
            std::array::from_fn(|c| if c < 3 && rgba[c] >= 0.0 { rest[c].clamp(0.0, rgba[c]) } else { rest[c] });
        let other_share = rest[3].min(1.0 - PURE);
        let seen = rest.map(|c| c / rest[3]);
        let own = [0, 1, 2, 3].map(|c| {
            let own = (rgba[c] - other_share * seen[c]) / (1.0 - other_share);
            if rgba[c] >= 0.0 { own.max(0.0) } else { own }
        });
        // A hidden layer knows the colour of the far surface over the whole pixel, not only where it is seen
        let other = hidden.and(same).map_or(seen, |hidden| hidden.rgba);
        let (near, far, share) = if is_near { (own, other, 1.0 - other_share) } else { (other, own, other_share) };
        let other_slope = same.map_or([0.0; 2], |beside| beside.slope);
        let doubt = MIXED_KNOWN * share.min(1.0 - share) * rms([0, 1, 2, 3].map(|c| near[c] - far[c]));
        Some(Split { index, is_near, share, near, far, doubt, other_depth, other_slope })
    }

    /// Guesses of the pixel's own surface and of the other one, from pure pixels where there are any, and the share of
    /// the pixels around (by a tent) that lie on its own side.
    fn guesses(&self, index: usize) -> (Option<Guess>, Option<Guess>, f32) {
        let width = self.first.window.width as usize;
        let (x, y) = ((index % width) as i32, (index / width) as i32);
        let (here, slope) = (self.first.inverse_depth[index], self.first.slope(index, x as usize));
        let is_near = self.sides[index] == Side::Near;
        let [mut own, mut own_mixed, mut other, mut other_mixed] = [Guess::default(); 4];
        let mut tent = 0.25;
        for (dx, dy) in neighbours(UNMIX_REACH) {
            let (u, v) = (x + dx, y + dy);
            let share = ((2 - dx.abs()).max(0) * (2 - dy.abs()).max(0)) as f32 / 16.0;
            if u < 0 || v < 0 || u >= width as i32 || v >= self.first.window.height as i32 {
                tent += share;
                continue;
            }
            let i = v as usize * width + u as usize;
            let step = self.first.inverse_depth[i] - here - (slope[0] * dx as f32 + slope[1] * dy as f32);
            let is_other = if is_near { step < -self.jump } else { step > self.jump };
            tent += if is_other { 0.0 } else { share };
            let is_pure = self.sides[i] == Side::Pure;
            let guess = match (is_other, is_pure) {
                (true, true) => &mut other,
                (true, false) => &mut other_mixed,
                (false, _) if step.abs() > self.jump => continue,
                (false, true) => &mut own,
                (false, false) => &mut own_mixed,
            };
            let weight = self.nearness[(dx * dx + dy * dy) as usize];
            guess.add(
                weight,
                self.first.rgba[i],
                self.first.inverse_depth[i],
                self.first.slope(i, u as usize),
                (dx, dy),
            );
        }
        (own.mean().or_else(|| own_mixed.mean()), other.mean().or_else(|| other_mixed.mean()), tent)
    }

    /// The first hidden surface behind a pixel.
    fn hidden(&self, index: usize) -> Option<Guess> {
        let farther = self.first.inverse_depth[index] - self.jump;
        let surface = self.behind.iter().find(|s| s.cover[index] > 0.5 && s.inverse_depth[index] < farther)?;
        let rgba = surface.rgba[index].map(|c| c / surface.cover[index]);
        let (depth, slope) = (surface.inverse_depth[index], surface.slopes[index]);
        Some(Guess { weight: 1.0, rgba, variance: 0.0, depth, nearest: depth, slope })
    }
}
