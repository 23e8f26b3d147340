//! What all frames of a sequence share, so that nothing jumps from one to the next: what depth is taken as, and the ground.

use std::collections::BTreeMap;

use clap::ValueEnum;
use optics::{Film, Ground};
use rayon::prelude::*;
use rgbd::DepthConvention;

use super::aim;
use super::input::{Input, read};
use super::job::{Job, Say};
use super::{Options, Source};
use crate::console::{is_interrupted, say};

/// How the ground of a sequence is found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum GroundRule {
    /// In some frames, for all of them.
    #[default]
    Steady,
    /// In each frame anew.
    Each,
}

/// Frames whose number is a multiple of this are looked at, so that it does not matter which are done already.
const STEP: i64 = 8;

/// Grounds that differ by no more than this, over the nearest inverse depth, are one that trembles.
const SAME: f64 = 0.02;

/// Gives all frames what they share. Depends on the frames that are there, not on which of them are to be made nor in what order.
pub(super) fn share(frames: &mut [(i64, Job)], options: &Options) {
    let source = Source { film: &options.film, read: &options.read };
    if options.read.depth_as().is_none() {
        let convention = told(frames, &source);
        frames.iter_mut().for_each(|(_, job)| job.convention = convention);
    }
    if frames.iter().all(|(_, job)| job.lens.focus.is_none()) || options.frames.ground == GroundRule::Each {
        return;
    }
    if let Some(grounds) = Grounds::of(frames, &source) {
        say(format_args!("{grounds}"));
        frames.iter_mut().for_each(|(frame, job)| job.ground = Some(grounds.at(*frame)));
    }
}

/// What the flat surfaces of the first frame that can be read say of its depth.
fn told(frames: &[(i64, Job)], source: &Source<'_>) -> Option<DepthConvention> {
    // Of deep or own files and photos nobody asks
    const MOST: usize = 8;
    let quiet: Say<'_> = &|_| ();
    frames.iter().take(MOST).find_map(|(_, job)| read(job, source, quiet).ok())?.told
}

/// The grounds that were found, by frame.
#[derive(Debug, PartialEq)]
struct Grounds {
    /// One, where the camera stands still; else one for each frame that was looked at.
    found: BTreeMap<i64, Ground>,
    looked_at: usize,
}

impl Grounds {
    /// Looks at some frames, as many at a time as there are threads; `None` where none has a ground.
    fn of(frames: &[(i64, Job)], source: &Source<'_>) -> Option<Self> {
        let ends = [frames.first()?.0, frames.last()?.0];
        let wanted = |frame: i64| frame % STEP == 0 || ends.contains(&frame);
        let looked_at: Vec<&(i64, Job)> = frames.iter().filter(|(frame, _)| wanted(*frame)).collect();
        let of_frame = |(frame, job): &&(i64, Job)| {
            let quiet: Say<'_> = &|_| ();
            let Input { frame: picture, lens, .. } = read(job, source, quiet).ok().filter(|_| !is_interrupted())?;
            let display = picture.display;
            let picture = picture.covering(display);
            let (ground, film) = aim::ground(job, source, &picture, &lens).ok()?;
            Some((*frame, ground, film))
        };
        let found: Vec<(i64, Ground, Film)> = looked_at.par_iter().filter_map(of_frame).collect();
        let film = found.first()?.2;
        Self::from_found(found.into_iter().map(|(frame, ground, _)| (frame, ground)).collect(), &film, looked_at.len())
    }

    fn from_found(found: BTreeMap<i64, Ground>, film: &Film, looked_at: usize) -> Option<Self> {
        let all: Vec<Ground> = found.values().copied().collect();
        let median = Ground::median(&all)?;
        // One in ten may be wrong
        let apart = all.iter().filter(|ground| median.difference(ground, film) > SAME).count();
        if 10 * apart <= all.len() {
            return Some(Self { found: [(0, median)].into(), looked_at });
        }
        // Each the middle of itself and its neighbours
        let calm = (0..all.len()).map(|i| {
            let around = &all[i.saturating_sub(1)..(i + 2).min(all.len())];
            // The ends have one neighbour only
            if around.len() == 3 { Ground::median(around).unwrap_or(all[i]) } else { all[i] }
        });
        Some(Self { found: found.keys().copied().zip(calm).collect(), looked_at })
    }

    /// The ground of a frame.
    fn at(&self, frame: i64) -> Ground {
        let before = self.found.range(..=frame).next_back();
        let after = self.found.range(frame..).next();
        match (before, after) {
            (Some((&a, from)), Some((&b, to))) if a < b => from.toward(to, (frame - a) as f64 / (b - a) as f64),
            (Some((_, ground)), _) | (None, Some((_, ground))) => *ground,
            (None, None) => unreachable!("grounds are never empty"),
        }
    }
}

impl std::fmt::Display for Grounds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let looked_at = self.looked_at;
        match (self.found.len(), self.found.values().next()) {
            (1, Some(ground)) => write!(
                f,
                "one ground for all frames, from {looked_at} of them: {:.4} m below the lens (--ground each finds it anew in each)",
                ground.height()
            ),
            (count, _) => write!(
                f,
                "the camera moves: the ground goes along {count} of {looked_at} frames looked at (--ground each finds it anew in each)"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec2, DVec3};

    /// A floor `height` below a lens that looks a little down.
    fn floor(height: f64) -> Ground {
        let w = DVec3::new(0.0, -0.9, 0.4).normalize() / height;
        let q = |i: i32| DVec2::new(f64::from(i % 20) / 20.0 - 0.5, -f64::from(i / 20) / 60.0);
        let samples: Vec<(DVec2, f64)> = (0..400).map(|i| (q(i), w.dot(q(i).extend(1.0)))).collect();
        Ground::find(&samples).expect("a floor")
    }

    fn film() -> Film {
        Film::new(DVec2::new(-0.5, -0.3), DVec2::new(0.5, 0.3), 100, 60).unwrap()
    }

    #[test]
    fn a_ground_that_trembles_is_one_for_all_frames() {
        // Half a per cent to and fro, and one frame that is quite wrong
        let height = |i: i64| if i == 48 { 2.5 } else { 1.6 * (1.0 + 0.005 * (i as f64 * 1.7).sin()) };
        let found: BTreeMap<i64, Ground> = (0..12).map(|i| (8 * i, floor(height(8 * i)))).collect();
        let grounds = Grounds::from_found(found, &film(), 12).unwrap();
        assert!((-5..105).all(|frame| grounds.at(frame) == grounds.at(0)));
        assert!((grounds.at(0).height() / 1.6 - 1.0).abs() < 0.005);
    }

    #[test]
    fn a_camera_that_rises_takes_the_ground_along_without_a_jump() {
        let found: BTreeMap<i64, Ground> = (0..12).map(|i| (8 * i, floor(1.6 + 0.1 * i as f64))).collect();
        let grounds = Grounds::from_found(found, &film(), 12).unwrap();
        let inverse: Vec<f64> = (0..=88).map(|frame| grounds.at(frame).height().recip()).collect();
        let steps: Vec<f64> = inverse.windows(2).map(|pair| pair[0] - pair[1]).collect();
        // From 1/1.6 down to 1/2.7 in 88 steps, none of which is more than that between the first two grounds
        let most = (1.0 / 1.6 - 1.0 / 1.7) / 8.0;
        assert!(steps.iter().all(|&step| step > 0.0 && step <= most * 1.001), "{steps:?}");
        for i in 0..12_i64 {
            assert!((grounds.at(8 * i).height() - (1.6 + 0.1 * i as f64)).abs() < 1e-6, "frame {}", 8 * i);
        }
    }
}
