//! Why the filter's picture is wrong: every named cause's share of its squared error, by experiments.
//!
//! The tracer can give the filter what a real frame lacks. One fixed chain of experiments starts from the filter as it is
//! shipped (merged gather, the kernel that it chooses itself, the frame that `tiltshift render` writes) and switches off one
//! more cause at each step:
//!
//! | cause | switched off by |
//! | --- | --- |
//! | frame border | all the margin that the lens sees, instead of the shipped one |
//! | undersampled colour | four times as many samples of the first layer's colour |
//! | hidden background | the surface behind the first one, instead of a guess (with one layer only) |
//! | further hidden layers | the surfaces behind that one |
//! | mixed colour at silhouettes | filtered in finer pixels and averaged, where the blur has a silhouette in reach |
//! | small discs | the same elsewhere |
//! | kernel shape | the exact footprint |
//! | leakage | lens rays, exact lens point by lens point, instead of the gather |
//!
//! A *share* is the drop of the squared error at a cause's step over the whole error; it may be negative. The chain
//! reversed (leakage first, border last) gives a second share, and both together a range: causes that only help together
//! have a wide one. What is left when all are switched off is the *rest*. The reference's noise is never in these errors:
//! they are products with its two halves, and it is stated beside them.
//!
//! Three things the chain cannot tell apart. Finer pixels unmix silhouettes and make small discs large at once: where a silhouette
//! is in reach the drop counts as mixed colour. Lens rays always have the exact footprint, so that in the reversed chain the
//! kernel's shape has no share of its own. Mirrors, glass and lamps brighter than the frame holds have no step, as the
//! tracer's shading depends on no view and clips nothing.
//!
//! A mask alone explains nothing. A pixel's error (mean over 5x5 pixels) counts as explained by the cause with the largest drop
//! there, if that experiment removes at least half of what was left before it; as *several* if only all experiments
//! together remove half; else as *unexplained*.

mod cause;
mod chain;
mod experiment;
mod inputs;
mod page;

use compare::Reference;
use optics::{Camera, KernelModel};
use rgbd::{Cancelled, Picture, Progress};
use trace::Scene;

pub use cause::Cause;
pub(crate) use cause::SwitchedOff;
pub use chain::{CauseShare, Shares, Verdict};
pub use page::{CAUSES_FORMAT, CausesReport};

use crate::{StudyError, causes::experiment::Experiments, step::Step};

/// What is shipped, and how far the experiments go beyond it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CausesSettings {
    /// Samples per pixel of the shipped colour.
    pub color_samples: u32,
    /// Columns and rows of margin that are shipped on each side, in pixels, as far as the lens needs them.
    pub margin: [u32; 2],
    /// Layers of the frame in which nothing hidden is missing.
    pub most_layers: usize,
    /// Finer pixels along the side of a pixel, 2 to 8.
    pub fine: u32,
    /// Lens rays of each finer pixel, 1 to 1024.
    pub lens_samples: u32,
    /// Seed of the frame's colour.
    pub seed: u64,
}

impl CausesSettings {
    /// As `tiltshift render` writes frames for a camera: 256 samples, a margin of up to a quarter of the width.
    #[must_use]
    pub fn shipped(camera: &Camera) -> Self {
        let margin = [camera.film.width().div_ceil(4); 2];
        Self { color_samples: 256, margin, most_layers: 6, fine: 4, lens_samples: 64, seed: 3 }
    }

    fn check(&self) -> Result<(), StudyError> {
        for (what, value, range, wanted) in [
            ("number of layers of the whole frame", self.most_layers as u64, 3..=16, "3 to 16"),
            ("number of finer pixels in a pixel's side", u64::from(self.fine), 2..=8, "2 to 8"),
            ("number of lens rays of a finer pixel", u64::from(self.lens_samples), 1..=1024, "1 to 1024"),
        ] {
            if !range.contains(&value) {
                return Err(StudyError::BadSetting { what, value: value as f64, wanted });
            }
        }
        Ok(())
    }
}

/// The causes of a filter's error on one view.
#[derive(Debug, Clone, PartialEq)]
pub struct Causes {
    /// How many layers the filter is given: 1, or 2 with one hidden.
    pub layers: usize,
    /// The shares, and the map.
    pub shares: Shares,
    /// The kernel that the filter chose by itself; the same for both.
    pub kernel: KernelModel,
    /// The picture with every cause in it.
    pub shipped: Picture,
    /// The picture with all of them switched off.
    pub best: Picture,
}

/// Runs the chain and the chain reversed on a view, for the filter with one layer and with two, against a reference of the
/// camera's whole film.
pub fn causes(
    scene: &Scene,
    camera: &Camera,
    reference: &Reference,
    settings: &CausesSettings,
    progress: &dyn Progress,
) -> Result<[Causes; 2], StudyError> {
    settings.check()?;
    let half = |index: usize| Step { whole: progress, index, count: 2 };
    let mut experiments = Experiments::new(scene, camera, settings, &half(0))?;
    let filtering = half(1);

    // Hold every picture of both chains against the reference
    let run = |(turn, layers): (usize, usize), experiments: &mut Experiments| {
        let (chain, start) = chain_of(layers);
        let orders = [chain.clone(), chain.iter().rev().copied().collect()];
        let (mut errors, mut ends) = (Vec::new(), Vec::new());
        for (direction, order) in orders.iter().enumerate() {
            let (mut off, mut of_order) = (start, Vec::new());
            for k in 0..=order.len() {
                let index = (2 * turn + direction) * (Cause::EVERY.len() + 1) + k;
                let step = Step { whole: &filtering, index, count: 4 * (Cause::EVERY.len() + 1) };
                let picture = experiments.picture(off, &step)?;
                if progress.is_cancelled() {
                    return Err(StudyError::from(Cancelled));
                }
                of_order.push(reference.squared_error(&picture)?);
                match order.get(k) {
                    Some(&cause) => off = off.with(cause),
                    None => ends.push(picture),
                }
            }
            errors.push(of_order);
        }
        let shares = Shares::new(&chain, &errors[0], &errors[1]);
        let shipped = experiments.picture(start, &filtering)?;
        let kernel = experiments.kernel().expect("a kernel of the first picture");
        Ok(Causes { layers, shares, kernel, shipped, best: ends.swap_remove(0) })
    };
    Ok([run((0, 1), &mut experiments)?, run((1, 2), &mut experiments)?])
}

/// The causes that stand in the picture of a filter with so many layers, and those that do not.
fn chain_of(layers: usize) -> (Vec<Cause>, SwitchedOff) {
    let start = if layers > 1 { SwitchedOff::default().with(Cause::SecondLayer) } else { SwitchedOff::default() };
    (Cause::EVERY.into_iter().filter(|&cause| !start.has(cause)).collect(), start)
}
