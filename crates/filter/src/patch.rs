//! One pixel of a surface as a small plane: what a lens ray can hit.

use rayon::prelude::*;
use rgbd::PixelWindow;

use crate::surface::Surface;

/// Inverse depth over one pixel, `s + gx dx + gy dy` at an offset (x right, y down) from its centre.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Patch {
    pub(crate) s: f32,
    pub(crate) gx: f32,
    pub(crate) gy: f32,
    /// How far a neighbour's plane may be off at the common border and still be the same surface; negative where there is
    /// no surface.
    pub(crate) slack: f32,
}

impl Patch {
    const NOTHING: Self = Self { s: 0.0, gx: 0.0, gy: 0.0, slack: -1.0 };

    #[inline(always)]
    pub(crate) fn is_there(&self) -> bool {
        self.slack >= 0.0
    }

    #[inline(always)]
    pub(crate) fn at(&self, dx: f32, dy: f32) -> f32 {
        self.s + self.gx * dx + self.gy * dy
    }

    /// Whether a patch at (dx, dy) lies on the same surface.
    #[inline(always)]
    fn goes_on(&self, dx: i32, dy: i32, other: &Self) -> bool {
        other.is_there() && (other.s - self.at(dx as f32, dy as f32)).abs() <= self.slack + other.slack
    }

    /// Half of what it rises over the pixel.
    pub(crate) fn rise(&self) -> f32 {
        0.5 * (self.gx.abs() + self.gy.abs())
    }
}

/// The patches of a surface. `slack` is the step in inverse depth that does not count as an edge; `is_whole` tells that
/// slopes are to be found from the pixels around, where the surface's own ones serve only beside nothing.
fn patches(surface: &Surface, slack: f32, is_whole: bool) -> Vec<Patch> {
    let window = surface.window;
    let value = |x: i32, y: i32| {
        let i = window.contains(x, y).then(|| window.index(x, y))?;
        (surface.cover[i] > 0.0).then_some(surface.inverse_depth[i])
    };
    let patch = |(x, y): (i32, i32)| {
        let i = window.index(x, y);
        if surface.cover[i] <= 0.0 {
            return Patch::NOTHING;
        }
        let alone = if is_whole { [0.0; 2] } else { surface.slope(i, (x - window.x) as usize) };
        let gx = slope([-2, -1, 0, 1, 2].map(|d| value(x + d, y)), slack, alone[0]);
        let gy = slope([-2, -1, 0, 1, 2].map(|d| value(x, y + d)), slack, alone[1]);
        let patch = Patch { s: surface.inverse_depth[i], gx, gy, slack };
        Patch { slack: slack + patch.rise(), ..patch }
    };
    window.pixels().map(patch).collect()
}

/// The slope at the middle one of five values in a row: central where they lie on one line, else that of the side which
/// is straighter (Harten's ENO choice); `alone` where neither side goes on as a surface does.
fn slope(values: [Option<f32>; 5], slack: f32, alone: f32) -> f32 {
    let [far_before, before, here, after, far_after] = values;
    let Some(here) = here else { return 0.0 };
    let (before_step, after_step) = (before.map(|v| here - v), after.map(|v| v - here));

    // A slope counts where the next step is like it: an edge is a step with none like it
    let bend = |near: Option<f32>, far: Option<f32>, step: f32| match (near, far) {
        (Some(near), Some(far)) => (here - 2.0 * near + far).abs(),
        _ => step.abs(),
    };
    let mut best = (f32::INFINITY, alone);
    let mut offer = |bend: f32, step: f32, largest: f32| {
        if bend <= 0.5 * largest + slack && bend < best.0 {
            best = (bend, step);
        }
    };
    if let (Some(a), Some(b)) = (before_step, after_step) {
        offer((b - a).abs(), 0.5 * (a + b), a.abs().max(b.abs()));
    }
    if let Some(step) = before_step {
        offer(bend(before, far_before, step), step, step.abs());
    }
    if let Some(step) = after_step {
        offer(bend(after, far_after, step), step, step.abs());
    }
    best.1
}

/// All patches of all surfaces, and what lies where.
pub(crate) struct Patches {
    pub(crate) window: PixelWindow,
    /// By surface, row by row.
    pub(crate) layers: Vec<Vec<Patch>>,
    /// By surface, row by row: whether all eight neighbours lie on the same surface in the same layer.
    seamless: Vec<Vec<bool>>,
    /// Row by row: after how many surfaces nothing more comes in a pixel.
    depths: Vec<u16>,
}

impl Patches {
    /// The patches of `surfaces`, of which the first fills the window.
    pub(crate) fn new(surfaces: &[Surface], slack: f32) -> Self {
        let window = surfaces[0].window;
        let layers: Vec<Vec<Patch>> =
            surfaces.par_iter().enumerate().map(|(n, surface)| patches(surface, slack, n == 0)).collect();
        let depth = |i: usize| surfaces.iter().rposition(|surface| surface.cover[i] > 0.0).map_or(0, |n| n + 1);
        let depths = (0..window.area()).into_par_iter().map(|i| depth(i).min(usize::from(u16::MAX)) as u16).collect();
        let is_seamless = |patches: &Vec<Patch>, x: i32, y: i32| {
            let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            let patch = &patches[window.index(x, y)];
            patch.is_there()
                && around.into_iter().all(|(dx, dy)| {
                    window.contains(x + dx, y + dy) && patch.goes_on(dx, dy, &patches[window.index(x + dx, y + dy)])
                })
        };
        let seamless = |patches| window.pixels().map(|(x, y)| is_seamless(patches, x, y)).collect();
        let seamless = layers.par_iter().map(seamless).collect();
        Self { window, layers, seamless, depths }
    }

    /// The surfaces that a pixel may hold.
    #[inline(always)]
    pub(crate) fn of_pixel(&self, index: usize) -> &[Vec<Patch>] {
        &self.layers[..usize::from(self.depths[index])]
    }

    /// Whether all eight neighbours of a pixel lie on its surface, in the same layer.
    #[inline(always)]
    pub(crate) fn is_seamless(&self, layer: usize, index: usize) -> bool {
        self.seamless[layer][index]
    }

    /// The layer that goes on with the surface of a pixel at the neighbour at (dx, dy); its own, where that does.
    pub(crate) fn next_layer(&self, layer: usize, index: usize, dx: i32, dy: i32, neighbour: usize) -> Option<usize> {
        let patch = &self.layers[layer][index];
        let goes_on = |&other: &usize| patch.goes_on(dx, dy, &self.layers[other][neighbour]);
        std::iter::once(layer).chain(0..usize::from(self.depths[neighbour])).find(goes_on)
    }
}
