//! One pixel of a surface as a small plane: what a lens ray can hit.

use rayon::prelude::*;
use rgbd::PixelWindow;

use crate::{beside::Beside, fragment::Fragment, surface::Surface};

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

/// A piece of surface of a pixel: its first one, or one beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum PieceId {
    First,
    Beside(usize),
}

/// All patches of all surfaces, and what lies where.
pub(crate) struct Patches {
    pub(crate) window: PixelWindow,
    /// The first surface's, row by row, and those of the pieces beside it.
    first: Vec<Patch>,
    of_beside: Vec<Patch>,
    /// Whether all eight neighbours lie on the same surface in the same layer.
    is_first_seamless: Vec<bool>,
    is_beside_seamless: Vec<bool>,
    beside: Beside,
}

impl Patches {
    /// The patches of the `first` surface, which fills the window, and of what is `beside` it. `slack` is the step in inverse
    /// depth that does not count as an edge.
    pub(crate) fn new(first: &Surface, beside: Beside, slack: f32) -> Self {
        let window = first.window;
        let place = |i: usize| {
            let (column, row) = (i as i32 % window.width as i32, i as i32 / window.width as i32);
            (window.x + column, window.y + row)
        };

        // Slopes are found from the pixels around; beside nothing a piece has its own
        let fragments = beside.fragments();
        let value = |layer: u16, x: i32, y: i32| {
            let i = window.contains(x, y).then(|| window.index(x, y))?;
            if layer == 0 {
                return (first.cover[i] > 0.0).then_some(first.inverse_depth[i]);
            }
            beside.in_layer(i, layer).map(|k| fragments[k].inverse_depth)
        };
        let patch = |layer: u16, (x, y): (i32, i32), alone: [f32; 2]| {
            let Some(s) = value(layer, x, y) else { return Patch::NOTHING };
            let gx = slope([-2, -1, 0, 1, 2].map(|d| value(layer, x + d, y)), slack, alone[0]);
            let gy = slope([-2, -1, 0, 1, 2].map(|d| value(layer, x, y + d)), slack, alone[1]);
            let patch = Patch { s, gx, gy, slack };
            Patch { slack: slack + patch.rise(), ..patch }
        };
        let first_patches = (0..window.area()).into_par_iter().map(|i| patch(0, place(i), [0.0; 2])).collect();
        let of_fragment = |k: usize| patch(beside.layer(k), place(fragments[k].index as usize), fragments[k].slope);
        let of_beside = (0..fragments.len()).into_par_iter().map(of_fragment).collect();

        let mut patches = Self {
            window,
            first: first_patches,
            of_beside,
            is_first_seamless: Vec::new(),
            is_beside_seamless: Vec::new(),
            beside,
        };
        let is_seamless = |piece: PieceId, i: usize| {
            let ((x, y), patch) = (place(i), patches.patch(piece, i));
            let mut around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            patch.is_there()
                && around.all(|(dx, dy)| {
                    let goes_on = |i: usize| {
                        let other = patches.in_layer_of(piece, i)?;
                        Some(patch.goes_on(dx, dy, patches.patch(other, i)))
                    };
                    window.contains(x + dx, y + dy) && goes_on(window.index(x + dx, y + dy)).unwrap_or(false)
                })
        };
        let is_first_seamless = (0..window.area()).into_par_iter().map(|i| is_seamless(PieceId::First, i)).collect();
        let fragments = patches.beside.fragments();
        let of_fragment = |k: usize| is_seamless(PieceId::Beside(k), fragments[k].index as usize);
        let is_beside_seamless = (0..fragments.len()).into_par_iter().map(of_fragment).collect();
        (patches.is_first_seamless, patches.is_beside_seamless) = (is_first_seamless, is_beside_seamless);
        patches
    }

    /// The patch of a piece of a pixel.
    #[inline(always)]
    pub(crate) fn patch(&self, piece: PieceId, index: usize) -> &Patch {
        match piece {
            PieceId::First => &self.first[index],
            PieceId::Beside(k) => &self.of_beside[k],
        }
    }

    /// The pieces of a pixel, first surface first.
    #[inline(always)]
    pub(crate) fn of_pixel(&self, index: usize) -> impl Iterator<Item = PieceId> + use<> {
        std::iter::once(PieceId::First).chain(self.beside.of_pixel(index).map(PieceId::Beside))
    }

    /// Whether a pixel holds no more than its first surface.
    #[inline(always)]
    pub(crate) fn is_single(&self, index: usize) -> bool {
        self.beside.of_pixel(index).is_empty()
    }

    /// What else is known of a piece beside the first surface.
    #[inline(always)]
    pub(crate) fn fragment(&self, k: usize) -> &Fragment {
        &self.beside.fragments()[k]
    }

    /// Whether all eight neighbours of a piece's pixel lie on its surface, in the same layer.
    #[inline(always)]
    pub(crate) fn is_seamless(&self, piece: PieceId, index: usize) -> bool {
        match piece {
            PieceId::First => self.is_first_seamless[index],
            PieceId::Beside(k) => self.is_beside_seamless[k],
        }
    }

    /// The piece of a pixel in the layer of another piece.
    #[inline(always)]
    pub(crate) fn in_layer_of(&self, piece: PieceId, index: usize) -> Option<PieceId> {
        match piece {
            PieceId::First => Some(PieceId::First),
            PieceId::Beside(k) => self.beside.in_layer(index, self.beside.layer(k)).map(PieceId::Beside),
        }
    }

    /// The piece that goes on with the surface of another at the neighbour at (dx, dy); that in its own layer, where it does.
    pub(crate) fn next(&self, piece: PieceId, index: usize, dx: i32, dy: i32, neighbour: usize) -> Option<PieceId> {
        let patch = self.patch(piece, index);
        let goes_on = |&other: &PieceId| patch.goes_on(dx, dy, self.patch(other, neighbour));
        self.in_layer_of(piece, neighbour).into_iter().chain(self.of_pixel(neighbour)).find(goes_on)
    }
}
