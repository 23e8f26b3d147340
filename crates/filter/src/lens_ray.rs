//! A ray through the lens, followed over the pixels that it passes.
//!
//! At inverse depth s the ray of pixel q through the lens point L passes the pixel (DESIGN eq. 5)
//! `p(s) = q + (s - w(q)) (l - l_z q) / (1 - l_z w(q))`: a straight line in the picture, walked from near to far.

use glam::Vec2;

use crate::{
    depth_pyramid::{DepthPyramid, LEVELS, Range, SHIFTS},
    patch::{Patch, Patches, PieceId},
};

/// A ray by the pixels it passes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LensRay {
    /// The pixel it belongs to, as column and row of the surfaces' window; perhaps outside.
    pub(crate) column: i32,
    pub(crate) row: i32,
    /// Inverse depth of focus w(q).
    pub(crate) focus: f32,
    /// Pixels (x right, y down) per unit of defocus.
    pub(crate) pace: Vec2,
    /// Largest defocus: beyond it the ray stays on its pixel.
    pub(crate) limit: f32,
}

/// Where a ray meets a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Hit {
    pub(crate) piece: PieceId,
    /// Index of the pixel in the surfaces' window.
    pub(crate) index: usize,
    /// Inverse depth.
    pub(crate) s: f32,
    /// Offset from the receiving pixel's centre.
    pub(crate) offset: Vec2,
    /// Offset from the centre of the pixel that is hit.
    pub(crate) within: Vec2,
}

/// A pixel on the way, the inverse depths at which the ray enters and leaves it, and the pixel before.
struct Visit {
    dx: i32,
    dy: i32,
    enter: f32,
    leave: f32,
    before: Option<(i32, i32)>,
}

impl LensRay {
    #[inline(always)]
    fn offset(&self, s: f32) -> Vec2 {
        self.pace * (s - self.focus).clamp(-self.limit, self.limit)
    }

    /// Inverse depth at which the ray crosses the line at `edge` pixels right of (below) the centre; -inf if never.
    #[inline(always)]
    fn crossing(&self, edge: f32, inverse_pace: f32) -> f32 {
        let defocus = edge * inverse_pace;
        if defocus >= -self.limit { self.focus + defocus } else { f32::NEG_INFINITY }
    }

    /// Calls `meet` for each surface met between the inverse depths of `range`, nearest first, until it returns false.
    pub(crate) fn march(
        &self,
        patches: &Patches,
        pyramid: &DepthPyramid,
        range: Range,
        mut meet: impl FnMut(Hit) -> bool,
    ) {
        let window = patches.window;
        let step = [self.pace.x, self.pace.y].map(|pace| if pace > 0.0 { -1 } else { 1 });
        let inverse = [self.pace.x, self.pace.y].map(|pace| if pace == 0.0 { f32::NEG_INFINITY } else { 1.0 / pace });
        // The next border ahead of a block from `low` to `high` (inclusive), and when it is crossed
        let ahead = |axis: usize, low: i32, high: i32| {
            let edge = if step[axis] > 0 { high as f32 + 0.5 } else { low as f32 - 0.5 };
            if inverse[axis] == f32::NEG_INFINITY { f32::NEG_INFINITY } else { self.crossing(edge, inverse[axis]) }
        };

        // Start where the ray comes within the range
        let mut s = range.high;
        let start = self.offset(s);
        let (mut dx, mut dy) = (floor(start.x + 0.5), floor(start.y + 0.5));
        let mut before = None;
        let mut level = LEVELS - 1;
        loop {
            let (column, row) = (self.column + dx, self.row + dy);
            let inside = column >= 0 && row >= 0 && column < window.width as i32 && row < window.height as i32;

            // The block around, and when the ray leaves it
            let mask = (1 << SHIFTS[level]) - 1;
            let (left, top) = if inside { (column & mask, row & mask) } else { (0, 0) };
            let side = if inside { mask } else { 0 };
            let leave_x = ahead(0, dx - left, dx - left + side);
            let leave_y = ahead(1, dy - top, dy - top + side);
            let leave = leave_x.max(leave_y).max(range.low);

            // Look closer where the block holds what the ray may meet, wider where it does not
            let mut next_level = (level + 1).min(LEVELS - 1);
            if inside {
                let block = pyramid.block(level, column, row);
                if leave <= block.high && s >= block.low {
                    if level > 0 {
                        level -= 1;
                        continue;
                    }
                    let visit = Visit { dx, dy, enter: s, leave, before };
                    if !self.visit(patches, &visit, &mut meet) {
                        return;
                    }
                    next_level = 0;
                }
            }
            if leave <= range.low {
                return;
            }

            // Cross into the next block, at the row or column where the single steps would have led
            s = leave;
            let settle = |axis: usize, from: i32, end: i32, ties_first: bool| {
                let place = if axis == 0 { self.offset(s).x } else { self.offset(s).y };
                let mut at = floor(place + 0.5).clamp(from.min(end), from.max(end));
                let is_past = |at: i32| {
                    let crossed = ahead(axis, at, at);
                    crossed > s || (ties_first && crossed == s)
                };
                while at != end && is_past(at) {
                    at += step[axis];
                }
                while at != from && !is_past(at - step[axis]) {
                    at -= step[axis];
                }
                at
            };
            if leave_x >= leave_y {
                if side > 0 {
                    dy = settle(1, dy, if step[1] > 0 { dy - top + side } else { dy - top }, false);
                }
                dx = if step[0] > 0 { dx - left + side + 1 } else { dx - left - 1 };
                before = Some((dx - step[0], dy));
            } else {
                if side > 0 {
                    dx = settle(0, dx, if step[0] > 0 { dx - left + side } else { dx - left }, true);
                }
                dy = if step[1] > 0 { dy - top + side + 1 } else { dy - top - 1 };
                before = Some((dx, dy - step[1]));
            }
            level = next_level;
        }
    }

    /// Meets the surfaces of one pixel in their order; false once `meet` has enough.
    #[inline(always)]
    fn visit(&self, patches: &Patches, visit: &Visit, meet: &mut impl FnMut(Hit) -> bool) -> bool {
        let center = Vec2::new(visit.dx as f32, visit.dy as f32);
        let (enter, leave) = (self.offset(visit.enter) - center, self.offset(visit.leave) - center);
        let width = patches.window.width as usize;
        let index = (self.row + visit.dy) as usize * width + (self.column + visit.dx) as usize;

        let mut last = (f32::INFINITY, None);
        loop {
            // Find the next surface behind the last one
            let mut next: Option<(Hit, usize)> = None;
            for (order, piece) in patches.of_pixel(index).enumerate() {
                let patch = patches.patch(piece, index);
                if !patch.is_there() {
                    continue;
                }
                let in_front = visit.enter - patch.at(enter.x, enter.y);
                let hit = if in_front >= 0.0 {
                    if visit.leave - patch.at(leave.x, leave.y) >= 0.0 {
                        continue;
                    }
                    self.inside(patch, center)
                } else if self.is_continued(patches, visit, patch, -in_front) {
                    (visit.enter, enter)
                } else {
                    continue;
                };
                let is_after = hit.0 < last.0 || last.1.is_none_or(|last_order| hit.0 == last.0 && order > last_order);
                if is_after && next.is_none_or(|(next, _)| hit.0 > next.s) {
                    next = Some((Hit { piece, index, s: hit.0, offset: center + hit.1, within: hit.1 }, order));
                }
            }
            let Some((hit, order)) = next else { return true };
            if !meet(hit) {
                return false;
            }
            if patches.is_single(index) {
                return true;
            }
            last = (hit.s, Some(order));
        }
    }

    /// Where the ray crosses a patch inside its pixel: inverse depth, and offset from the pixel's centre.
    #[inline(always)]
    fn inside(&self, patch: &Patch, center: Vec2) -> (f32, Vec2) {
        let slope = Vec2::new(patch.gx, patch.gy);
        let defocus = (patch.s - self.focus - slope.dot(center)) / (1.0 - slope.dot(self.pace)).max(1e-6);
        let within =
            (self.pace * defocus.clamp(-self.limit, self.limit) - center).clamp(Vec2::splat(-0.5), Vec2::splat(0.5));
        (patch.at(within.x, within.y), within)
    }

    /// Whether the ray, `behind` a patch as it enters, was in front of the same surface in the pixel before.
    #[inline(always)]
    fn is_continued(&self, patches: &Patches, visit: &Visit, patch: &Patch, behind: f32) -> bool {
        if behind > patch.slack {
            return false;
        }
        let Some((dx, dy)) = visit.before else { return false };
        let window = patches.window;
        let (column, row) = (self.column + dx, self.row + dy);
        if column < 0 || row < 0 || column >= window.width as i32 || row >= window.height as i32 {
            return false;
        }
        let index = row as usize * window.width as usize + column as usize;
        let at = self.offset(visit.enter) - Vec2::new(dx as f32, dy as f32);
        patches.of_pixel(index).any(|piece| {
            let before = patches.patch(piece, index);
            let in_front = visit.enter - before.at(at.x, at.y);
            before.is_there() && in_front >= 0.0 && in_front + behind <= patch.slack
        })
    }
}

/// The largest integer not above `value`; without SSE 4.1 `f32::floor` is a call.
#[inline(always)]
pub(crate) fn floor(value: f32) -> i32 {
    let whole = value as i32;
    whole - i32::from(whole as f32 > value)
}

/// The pixel ranges of inverse depth that a ray must look into.
pub(crate) fn pixel_ranges(patches: &Patches) -> Vec<Range> {
    let range = |i: usize| {
        let there = patches.of_pixel(i).map(|piece| patches.patch(piece, i)).filter(|patch| patch.is_there());
        // A hair more, for what rounding may do
        let hair = |patch: &Patch| 1e-5 * (patch.s.abs() + patch.rise());
        there.fold(Range::EMPTY, |range, patch| {
            let (low, high) = (patch.s - patch.rise() - patch.slack, patch.s + patch.rise());
            range.union(Range { low: low - hair(patch), high: high + hair(patch) })
        })
    };
    (0..patches.window.area()).map(range).collect()
}
