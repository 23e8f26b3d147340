//! The ground: the largest plane below the camera that many depths agree on.
//!
//! In q and inverse depth a plane is affine (1/z = w . (q, 1)), so that three samples make a candidate and least squares a
//! refinement. Candidates are drawn as RANSAC draws them (Fischler and Bolles 1981), from a fixed seed: the same samples give
//! the same ground.

use glam::{DMat3, DVec2, DVec3};

use crate::{Film, Focus, OpticsError};

/// How often three samples are drawn: a ground that fills a tenth of the picture is missed once in two of a thousand cases
/// ((1 - 0.1^3)^6000).
const DRAWS: u32 = 6000;

/// How exact depths are taken to be, and the least share of the samples that must agree on a plane then: a renderer's first, and
/// if there is none those of a sensor or a guess, of which more must agree, since chance lets more of them.
const TRIES: [(f64, f64); 2] = [(1.0, 0.1), (3.0, 0.2)];

/// How far from the plane a sample may be, over its own inverse depth, and over the spread of all.
const OWN_ERROR: f64 = 0.01;
const SPREAD_ERROR: f64 = 0.004;

/// The least part of the normal that is upright, and the largest that leans aside: 60 degrees of looking down, 30 of roll.
const LEAST_UPRIGHT: f64 = 0.4;
const MOST_ASIDE: f64 = 0.5;

/// A plane that depths agree on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ground {
    plane: Focus,
    share: f64,
}

impl Ground {
    /// The ground below the camera among samples of pixel and inverse depth (0 for the sky); `None` where no plane that lies
    /// below the lens and does not lean aside more than 30 degrees, nor away from the camera by more than 66, holds a tenth of
    /// them within 1 % of inverse depth, or a fifth within 3 %.
    #[must_use]
    pub fn find(samples: &[(DVec2, f64)]) -> Option<Self> {
        if samples.len() < 3 {
            return None;
        }
        let spread = spread(samples);
        TRIES.into_iter().find_map(|(errors, least_share)| {
            Self::find_within(samples, errors, spread).filter(|ground| ground.share >= least_share)
        })
    }

    /// The plane that most samples agree on, within `errors` times the usual.
    fn find_within(samples: &[(DVec2, f64)], errors: f64, spread: f64) -> Option<Self> {
        let is_within = |part: f64, w: DVec3, &(q, inverse): &(DVec2, f64)| {
            let error = (inverse - w.dot(q.extend(1.0))).abs();
            inverse > 0.0 && error <= errors * part * (OWN_ERROR * inverse).max(SPREAD_ERROR * spread)
        };
        let agrees = |w: DVec3, sample: &(DVec2, f64)| is_within(1.0, w, sample);
        let count = |w: DVec3| samples.iter().filter(|sample| agrees(w, sample)).count();

        // Draw candidates, and judge them by a part of the samples first
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut draw = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            samples[(state % samples.len() as u64) as usize]
        };
        let few: Vec<(DVec2, f64)> = samples.iter().step_by(samples.len().div_ceil(500)).copied().collect();
        let mut best: Option<(usize, DVec3)> = None;
        for _ in 0..DRAWS {
            let Some(w) = through([draw(), draw(), draw()]).filter(|&w| is_ground(w)) else { continue };
            let found = few.iter().filter(|sample| agrees(w, sample)).count();
            if best.is_none_or(|(most, _)| found > most) {
                best = Some((found, w));
            }
        }

        // Refine it by those that agree
        let mut w = best?.1;
        for _ in 0..5 {
            let agreeing: Vec<(DVec2, f64)> = samples.iter().filter(|sample| agrees(w, sample)).copied().collect();
            match fitted(&agreeing).filter(|&better| is_ground(better) && count(better) >= agreeing.len()) {
                Some(better) if better != w => w = better,
                _ => break,
            }
        }

        // Then by those that agree well, where they are nearly all: what stands low on the ground pulls it up no more
        for part in [0.3, 0.1, 0.03] {
            let well: Vec<(DVec2, f64)> = samples.iter().filter(|sample| is_within(part, w, sample)).copied().collect();
            if (well.len() as f64) < 0.8 * count(w) as f64 {
                break;
            }
            w = fitted(&well).filter(|&better| is_ground(better)).unwrap_or(w);
        }
        let share = count(w) as f64 / samples.len() as f64;
        Some(Self { plane: Focus::from_finite(w), share })
    }

    /// The ground as a plane of focus: everything on it is sharp.
    #[must_use]
    pub fn plane(&self) -> Focus {
        self.plane
    }

    /// The middle of several: of each component of their planes, and of their shares, the median; `None` of none.
    #[must_use]
    pub fn median(grounds: &[Self]) -> Option<Self> {
        let middle = |value: fn(&Self) -> f64| {
            let mut values: Vec<f64> = grounds.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            let half = values.len() / 2;
            if values.len() % 2 == 1 { values[half] } else { 0.5 * (values[half - 1] + values[half]) }
        };
        if grounds.is_empty() {
            return None;
        }
        let w = DVec3::new(middle(|g| g.plane.w().x), middle(|g| g.plane.w().y), middle(|g| g.plane.w().z));
        Some(Self { plane: Focus::from_finite(w), share: middle(|g| g.share) })
    }

    /// A part of the way, from 0 to 1, from this ground to another: inverse depths go straight.
    #[must_use]
    pub fn toward(&self, other: &Self, part: f64) -> Self {
        Self {
            plane: Focus::from_finite(self.plane.w().lerp(other.plane.w(), part)),
            share: self.share + part * (other.share - self.share),
        }
    }

    /// How far two grounds are apart in a picture: the largest difference of inverse depth in its corners, over the largest inverse
    /// depth of this one there.
    #[must_use]
    pub fn difference(&self, other: &Self, film: &Film) -> f64 {
        let largest = |value: &dyn Fn(DVec2) -> f64| film.corners().into_iter().map(value).fold(0.0, f64::max);
        let apart = largest(&|q| (self.plane.inverse_depth(q) - other.plane.inverse_depth(q)).abs());
        apart / largest(&|q| self.plane.inverse_depth(q))
    }

    /// How many of the samples lie on it, 0 to 1.
    #[must_use]
    pub fn share(&self) -> f64 {
        self.share
    }

    /// Height of the lens above it, in the unit of depth.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.plane.distance()
    }

    /// The plane that stands on the ground at the point seen by pixel `q` at `depth`, across the view: only a strip of the
    /// ground is sharp, as in a model seen from near.
    pub fn standing_at(&self, q: DVec2, depth: f64) -> Result<Focus, OpticsError> {
        if !(depth > 0.0 && depth.is_finite()) {
            let (what, wanted) = ("depth to stand the plane of focus at", "positive and finite");
            return Err(OpticsError::OutOfRange { what, value: depth, wanted });
        }
        // The way the camera looks, laid on the ground
        let up = self.plane.w().normalize();
        let along = DVec3::Z - up * up.z;
        let distance = along.dot(q.extend(1.0) * depth);
        Focus::new(along / distance)
    }
}

/// Whether a plane lies below the lens and about level: its normal, away from the lens, points down.
fn is_ground(w: DVec3) -> bool {
    let normal = w.normalize_or_zero();
    -normal.y >= LEAST_UPRIGHT && normal.x.abs() <= MOST_ASIDE
}

/// From the 5th to the 95th part of a hundred of all inverse depths.
fn spread(samples: &[(DVec2, f64)]) -> f64 {
    let mut inverse: Vec<f64> = samples.iter().map(|&(_, inverse)| inverse).collect();
    inverse.sort_by(f64::total_cmp);
    let at = |part: f64| inverse[(part * (inverse.len() - 1) as f64) as usize];
    at(0.95) - at(0.05)
}

/// The plane through three samples; `None` if they lie on one line.
fn through(picks: [(DVec2, f64); 3]) -> Option<DVec3> {
    let picks = picks.map(|(q, inverse)| (q, inverse.recip()));
    Focus::through_pixels(picks).ok().map(|focus| focus.w())
}

/// The plane of least squares of inverse depth.
fn fitted(samples: &[(DVec2, f64)]) -> Option<DVec3> {
    let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for &(q, inverse) in samples {
        let p = q.extend(1.0);
        normal += DMat3::from_cols(p * p.x, p * p.y, p * p.z);
        right += p * inverse;
    }
    let w = normal.inverse() * right;
    w.is_finite().then_some(w)
}
