//! What the numbers of a depth channel are, told from planes.
//!
//! Seen through a pinhole, a plane has an inverse depth that is affine in the pixel. So on the flat patches of a picture `1/s` of
//! the stored numbers s is affine where they are planar depth, `|(q, 1)| / s` where they are distances along the ray, and `s`
//! itself where they are inverse depth. A patch has a say between two of these where it is so flat under the one that, were it
//! exactly so, it would bend under the other at least [`CLEAR`] times as much as what is left over: neither noise nor a curved
//! surface passes that but by chance.

use glam::{DMat3, DVec3};
use optics::Film;

use crate::depth_convention::cosine;
use crate::{DepthConvention, PixelWindow, Plane};

/// How many times larger than what is left over the bend under the other convention must be.
const CLEAR: f64 = 2.0;

/// What a float keeps of a number: less bend than a few of these tells nothing.
const LEAST_BEND: f64 = 1e-6;

/// Sides of patches over the larger side of the picture; each is sampled by at most [`GRID`] x [`GRID`] pixels.
const SIDES: [f64; 4] = [0.5, 0.25, 0.125, 0.0625];
const GRID: u32 = 16;
const LEAST_SIDE: f64 = 8.0;

/// Half widths in q to try where the film is not known: 20 to 100 degrees across.
const HALF_WIDTHS: [f64; 7] = [0.18, 0.25, 0.35, 0.5, 0.7, 0.95, 1.2];

/// The least number of patches, and the least confidence, that make a verdict.
const LEAST_VOTES: u32 = 3;
const LEAST_CONFIDENCE: f32 = 0.75;

const KINDS: [DepthConvention; 3] = [DepthConvention::Planar, DepthConvention::Ray, DepthConvention::Inverse];

/// What the flat parts of a depth channel say of its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthVerdict {
    /// What they are; `None` where no flat part tells.
    pub convention: Option<DepthConvention>,
    /// How sure that is, from 0.75 to 0.99: the share of the patches that agree, one added on each side (Laplace's rule).
    pub confidence: f32,
    /// How many flat patches agree, and how many contradict.
    pub patches: [u32; 2],
    /// Whether all numbers lie from 0 to 1 and reach 1: near and far may be normalised away.
    pub is_normalised: bool,
    /// Whether the field of view was known, without which distances along the ray cannot be told.
    pub knows_film: bool,
}

impl DepthVerdict {
    /// Of numbers as they are stored, backgrounds left out: what is not positive and finite is no depth. `display` is the window
    /// that `film` covers.
    #[must_use]
    pub fn of(stored: &Plane, display: PixelWindow, film: Option<&Film>) -> Self {
        let known = stored.values().iter().filter(|number| number.is_finite());
        let [least, most] = known.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], &x| [a.min(x), b.max(x)]);
        let is_normalised = least >= 0.0 && (0.99..=1.0).contains(&most) && least < most;
        let told = match film {
            Some(film) => Votes::of(stored, &|x, y| f64::from(cosine(Some((film, display)), x, y))).verdict(),
            None => without_film(stored, display),
        };
        Self { is_normalised, knows_film: film.is_some(), ..told }
    }

    /// Whether it says so surely enough that it is followed where nobody says otherwise.
    #[must_use]
    pub fn is_sure(&self) -> bool {
        const MANY: u32 = 8;
        self.convention.is_some() && self.confidence >= 0.9 && self.patches[0] >= MANY
    }
}

impl std::fmt::Display for DepthVerdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [agree, contradict] = self.patches;
        match self.convention {
            None if self.knows_film => f.write_str("no flat surface tells what the numbers are")?,
            None => f.write_str("without a field of view (--fov) no flat surface tells what the numbers are")?,
            Some(convention) => {
                write!(
                    f,
                    "{convention}, {:.0} % sure: {agree} of {} flat patches say so",
                    100.0 * self.confidence,
                    agree + contradict
                )?;
            }
        }
        if self.is_normalised {
            f.write_str("; they lie from 0 to 1 as if normalised")?;
        }
        Ok(())
    }
}

/// What holds for every field of view: planar and inverse depth may be told without one, but what bulges like a ball looks like
/// distances along the ray for some.
fn without_film(stored: &Plane, display: PixelWindow) -> DepthVerdict {
    let middle = [0.5 * f64::from(display.width), 0.5 * f64::from(display.height)];
    let of_half_width = |half: f64| {
        let scale = half / middle[0];
        let cosine = |x: i32, y: i32| {
            let q = [x - display.x, y - display.y].map(|i| f64::from(i) + 0.5);
            ((q[0] - middle[0]) * scale).hypot((q[1] - middle[1]) * scale).hypot(1.0).recip()
        };
        Votes::of(stored, &cosine).verdict()
    };
    let mut told: Vec<DepthVerdict> = HALF_WIDTHS.map(of_half_width).into_iter().collect();
    told.retain(|verdict| verdict.convention.is_some());
    let is_one = told.windows(2).all(|pair| pair[0].convention == pair[1].convention);
    let least = told.into_iter().reduce(|a, b| if b.confidence < a.confidence { b } else { a });
    match least.filter(|least| is_one && least.convention != Some(DepthConvention::Ray)) {
        Some(least) => least,
        None => Votes::default().verdict(),
    }
}

/// How often the first of two conventions was found right where it could be told from the second.
#[derive(Default)]
struct Votes([[u32; 3]; 3]);

impl Votes {
    fn of(stored: &Plane, cosine: &dyn Fn(i32, i32) -> f64) -> Self {
        let window = stored.window();
        let mut votes = Self::default();
        let larger = f64::from(window.width.max(window.height));
        for side in SIDES.map(|part| part * larger).into_iter().filter(|&side| side >= LEAST_SIDE) {
            let side = side as u32;
            let starts = |from: i32, length: u32| {
                (0..length.saturating_sub(side / 2)).step_by((side / 2).max(1) as usize).map(move |at| from + at as i32)
            };
            for y in starts(window.y, window.height) {
                for x in starts(window.x, window.width) {
                    let place = PixelWindow { x, y, width: side, height: side }.intersection(&window);
                    if 2 * place.width.min(place.height) > side {
                        votes.ask(stored, place, cosine);
                    }
                }
            }
        }
        votes
    }

    /// Lets a patch say what it has to say.
    fn ask(&mut self, stored: &Plane, place: PixelWindow, cosine: &dyn Fn(i32, i32) -> f64) {
        let Some(patch) = Patch::of(stored, place, cosine) else { return };
        let fits = KINDS.map(|kind| patch.fit(|i| patch.inverse(kind, i, patch.stored[i])));
        for (k, kind) in KINDS.into_iter().enumerate() {
            let Some(fit) = &fits[k] else { continue };
            for (j, other) in KINDS.into_iter().enumerate().filter(|&(j, _)| j != k) {
                let bend = patch.fit(|i| patch.inverse(other, i, patch.stored_of(kind, i, fit.at(&patch, i))));
                let is_clear = |bend: &Fit| bend.left > LEAST_BEND && CLEAR * fit.left < bend.left;
                if bend.as_ref().is_some_and(is_clear) {
                    self.0[k][j] += 1;
                }
            }
        }
    }

    fn verdict(&self) -> DepthVerdict {
        // A convention is as sure as the weaker of its two comparisons
        let sure = |k: usize| {
            let against = (0..3).filter(move |&j| j != k).map(move |j| [self.0[k][j], self.0[j][k]]);
            let share = |[won, lost]: [u32; 2]| f64::from(won + 1) / f64::from(won + lost + 2);
            against.min_by(|&a, &b| share(a).total_cmp(&share(b))).map(|weaker| (share(weaker) as f32, weaker))
        };
        let best = (0..3).filter_map(|k| Some((KINDS[k], sure(k)?))).reduce(|a, b| if b.1.0 > a.1.0 { b } else { a });
        let (kind, (share, patches)) = best.expect("three kinds");
        let is_told = share >= LEAST_CONFIDENCE && patches[0] >= LEAST_VOTES;
        DepthVerdict {
            convention: is_told.then_some(kind),
            confidence: if is_told { share.min(0.99) } else { 0.0 },
            patches: if is_told { patches } else { [0; 2] },
            is_normalised: false,
            knows_film: false,
        }
    }
}

/// Samples of a part of the picture.
struct Patch {
    /// From -1 to 1 each, and 1.
    places: Vec<DVec3>,
    stored: Vec<f64>,
    cosines: Vec<f64>,
}

/// An affine function over a patch, and what it leaves over: the root mean square, over the mean.
struct Fit {
    plane: DVec3,
    left: f64,
}

impl Fit {
    fn at(&self, patch: &Patch, i: usize) -> f64 {
        self.plane.dot(patch.places[i])
    }
}

impl Patch {
    /// The samples; `None` unless nearly all are depths.
    fn of(stored: &Plane, place: PixelWindow, cosine: &dyn Fn(i32, i32) -> f64) -> Option<Self> {
        let step = place.width.max(place.height).div_ceil(GRID).max(1) as usize;
        let mut patch = Self { places: Vec::new(), stored: Vec::new(), cosines: Vec::new() };
        let mut asked = 0;
        let scale = |at: i32, from: i32, length: u32| 2.0 * f64::from(at - from) / f64::from(length) - 1.0;
        for y in (place.y..place.y_end()).step_by(step) {
            for x in (place.x..place.x_end()).step_by(step) {
                asked += 1;
                let number = stored.at(x, y);
                if number > 0.0 && number.is_finite() {
                    patch.places.push(DVec3::new(scale(x, place.x, place.width), scale(y, place.y, place.height), 1.0));
                    patch.stored.push(f64::from(number));
                    patch.cosines.push(cosine(x, y));
                }
            }
        }
        // One number all over is a background or a hole rather than a wall
        let is_one = patch.stored.windows(2).all(|pair| pair[0] == pair[1]);
        (10 * patch.stored.len() >= 9 * asked && !is_one).then_some(patch)
    }

    /// What is affine on a plane, of a stored number of this kind.
    fn inverse(&self, kind: DepthConvention, i: usize, stored: f64) -> f64 {
        match kind {
            DepthConvention::Planar => stored.recip(),
            DepthConvention::Ray => (stored * self.cosines[i]).recip(),
            DepthConvention::Inverse => stored,
        }
    }

    /// The number that would be stored.
    fn stored_of(&self, kind: DepthConvention, i: usize, inverse: f64) -> f64 {
        match kind {
            DepthConvention::Planar => inverse.recip(),
            DepthConvention::Ray => (inverse * self.cosines[i]).recip(),
            DepthConvention::Inverse => inverse,
        }
    }

    /// The affine function of least squares; `None` where it passes 0, as no surface in sight does.
    fn fit(&self, value: impl Fn(usize) -> f64) -> Option<Fit> {
        let values: Vec<f64> = (0..self.places.len()).map(value).collect();
        let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for (&p, &value) in self.places.iter().zip(&values) {
            normal += DMat3::from_cols(p * p.x, p * p.y, p * p.z);
            right += p * value;
        }
        let plane = normal.inverse() * right;
        let count = values.len() as f64;
        let squares: f64 =
            self.places.iter().zip(&values).map(|(&p, &value)| (value - plane.dot(p)) * (value - plane.dot(p))).sum();
        let least = self.places.iter().map(|&p| plane.dot(p)).fold(f64::INFINITY, f64::min);
        let left = (squares / count).sqrt() / (values.iter().sum::<f64>() / count);
        (plane.is_finite() && least > 0.0 && left.is_finite()).then_some(Fit { plane, left })
    }
}
