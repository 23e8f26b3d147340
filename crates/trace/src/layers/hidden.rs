//! What lies behind the first surface and is seen by some point of the lens.

use glam::DVec2;
use rgbd::PixelWindow;

use super::facing::Facing;
use super::part::{Part, Seen, Surface, nearest};
use super::walk::{Met, Walk};
use crate::sampler::Sampler;

/// Samples of each half that the colour of hidden surfaces comes from where none of them ends: more make no filtered picture
/// truer.
const ENOUGH_INSIDE: u32 = 32;
/// Samples of each half that look for things which no pixel's centre meets.
const PROBES: u32 = 4;
/// Of what they find in a pixel, so many things are asked for whether some lens point sees them.
const MOST_ASKED: usize = 4;
/// Beyond the inverse depth of all that is looked for by this factor a line of sight is followed no more.
const BEYOND: f64 = 0.98;

/// A surface on the line of sight through a pixel's centre.
#[derive(Debug, Clone, Copy)]
pub(super) struct AtCentre {
    facing: Facing,
    /// Whether some lens point is known to see it there.
    is_seen: bool,
}

/// Finds up to `count` surfaces a pixel.
pub(super) struct Behind<'a> {
    pub(super) walk: Walk<'a>,
    pub(super) count: usize,
    /// Of each pixel and half, those samples that the first layer's colour is the mean of.
    pub(super) samples: u32,
    pub(super) seed: u64,
}

/// What the centres of the pixels of a window meet.
pub(super) struct Centres<'a> {
    pub(super) window: PixelWindow,
    pub(super) met: &'a [Vec<AtCentre>],
}

impl Centres<'_> {
    /// Behind the first surface, in the pixel itself and around it; with the pixels' places.
    fn around(&self, x: i32, y: i32) -> impl Iterator<Item = ((i32, i32), &AtCentre)> {
        let places = (-1..=1).flat_map(move |dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
        places
            .filter(|&(u, v)| self.window.contains(u, v))
            .flat_map(|(u, v)| self.met[self.window.index(u, v)].iter().skip(1).map(move |at| ((u, v), at)))
    }
}

impl Behind<'_> {
    /// What the centre of a pixel meets from near to far, the first surface first; of those behind it the nearest that some
    /// lens point sees are known to be seen, as many as are wanted.
    pub(super) fn at_centre(&self, x: i32, y: i32) -> Vec<AtCentre> {
        let mut wanted = self.count;
        let front = self.walk.along(centre(x, y)).filter(|met| met.is_first || met.is_front());
        let met = front.map(|met| {
            let is_seen = !met.is_first && wanted > 0 && self.walk.sees(&met);
            wanted -= usize::from(is_seen);
            AtCentre { facing: self.walk.facing(&met), is_seen }
        });
        met.collect()
    }

    /// The surfaces behind the first one in a pixel that some lens point sees, from near to far.
    pub(super) fn surfaces(&self, x: i32, y: i32, centres: &Centres) -> Vec<Surface> {
        let own = &centres.met[centres.window.index(x, y)];
        let Some(first) = own.first().map(|first| first.facing) else { return Vec::new() };
        let mut parts = self.expected(x, y, &first, centres);
        self.probe(x, y, own, &mut parts);
        if parts.is_empty() {
            return Vec::new();
        }

        // Meet them with some samples, with all where one of them ends, and ask those that some lens point may see
        let few = self.samples.min(ENOUGH_INSIDE);
        self.meet(x, y, few, &mut parts);
        if few < self.samples && !parts.iter().all(|part| part.hits.iter().all(Option::is_some)) {
            self.meet(x, y, self.samples, &mut parts);
        }
        for part in parts.iter_mut().filter(|part| part.seen == Seen::Unknown) {
            part.seen = Seen::at(&self.walk, part.hits.iter().flatten());
        }
        parts.retain(|part| part.seen != Seen::Share(0.0) && part.hits.iter().any(Option::is_some));
        let q = self.q(centre(x, y));
        parts.sort_by(|a, b| b.inverse_at(q, &self.walk).total_cmp(&a.inverse_at(q, &self.walk)));
        let samplers = self.samplers(x, y);
        nearest(parts, self.count).iter().map(|part| part.surface(q, &self.walk, &samplers)).collect()
    }

    /// What is to be expected in a pixel: the surfaces that some lens point sees at its own centre or at those around.
    fn expected(&self, x: i32, y: i32, first: &Facing, centres: &Centres) -> Vec<Part> {
        let own = &centres.met[centres.window.index(x, y)];
        let q = self.q(centre(x, y));
        let mut parts: Vec<Part> = Vec::new();
        for at in own.iter().filter(|at| at.is_seen) {
            // At the rim of what is seen only a share of the pixel is
            let is_here = |(u, v): (i32, i32), other: &Facing| is_same(&at.facing, q, other, self.q(centre(u, v)));
            let is_rim = centres.around(x, y).any(|(place, other)| !other.is_seen && is_here(place, &other.facing));
            parts.push(Part::new(at.facing, true, if is_rim { Seen::Unknown } else { Seen::ALL }));
        }
        for ((u, v), at) in centres.around(x, y).filter(|(_, at)| at.is_seen) {
            let there = self.q(centre(u, v));
            let is_here = |other: &Facing| is_same(other, q, &at.facing, there);
            if !is_behind(first, there, at.facing.inverse) || parts.iter().any(|part| is_here(&part.facing)) {
                continue;
            }
            let own = own[1..].iter().find(|own| is_here(&own.facing));
            parts.push(Part::new(own.map_or(at.facing, |own| own.facing), own.is_some(), Seen::Unknown));
        }
        parts
    }

    /// Adds what no centre meets, and leaves out what is not seen after all.
    fn probe(&self, x: i32, y: i32, own: &[AtCentre], parts: &mut Vec<Part>) {
        let expected = parts.len();
        let mut points = vec![Vec::new(); expected];
        let mut asked = 0;
        for at in self.places(x, y, PROBES.min(self.samples)) {
            let q = self.q(at);
            for met in self.walk.along(at).filter(Met::is_front) {
                let facing = self.walk.facing(&met);
                if let Some(k) = parts.iter().position(|part| part.facing.meets(q, facing.inverse)) {
                    points.get_mut(k).into_iter().for_each(|points| points.push(met));
                    continue;
                }
                // What lies first on its line is no hidden surface
                let is_known = own.iter().any(|own| own.facing.meets(q, facing.inverse));
                if asked < MOST_ASKED && !met.is_first && !is_known && is_behind(&own[0].facing, q, facing.inverse) {
                    asked += 1;
                    if self.walk.sees(&met) {
                        parts.push(Part::new(facing, false, Seen::ALL));
                    }
                }
            }
        }
        for (part, points) in parts.iter_mut().zip(points) {
            // What no centre meets may fill too little to be found by so few
            if part.seen == Seen::Unknown && part.is_central {
                part.seen = Seen::at(&self.walk, points.iter());
            }
        }
        parts.retain(|part| part.seen != Seen::Share(0.0));
    }

    /// Fills in where each of `samples` a half of a pixel meets each part, be it first on its line or not.
    fn meet(&self, x: i32, y: i32, samples: u32, parts: &mut [Part]) {
        parts.iter_mut().for_each(|part| part.hits = vec![None; 2 * samples as usize]);
        for (place, at) in self.places(x, y, samples).enumerate() {
            let q = self.q(at);
            let lowest = parts.iter().map(|part| part.facing.plane_at(q).min(part.facing.inverse));
            let last = BEYOND * lowest.fold(f64::INFINITY, f64::min);
            let mut left = parts.len();
            for met in self.walk.along(at) {
                let inverse = self.walk.facing(&met).inverse;
                if inverse < last {
                    break;
                }
                let mut missed = parts.iter_mut().filter(|part| part.hits[place].is_none());
                if let Some(part) = missed.find(|part| met.is_front() && part.facing.meets(q, inverse)) {
                    part.hits[place] = Some(met);
                    left -= 1;
                    if left == 0 {
                        break;
                    }
                }
            }
        }
    }

    /// Direction of a continuous pixel coordinate.
    fn q(&self, at: DVec2) -> DVec2 {
        self.walk.camera.film.q_from_pixel(at)
    }

    fn samplers(&self, x: i32, y: i32) -> [Sampler; 2] {
        [0, 1].map(|half| Sampler::new(self.seed, x, y, half))
    }

    /// Where the first `samples` of each half of a pixel lie, half by half.
    fn places(&self, x: i32, y: i32, samples: u32) -> impl Iterator<Item = DVec2> {
        let corner = DVec2::new(f64::from(x), f64::from(y));
        let samplers = self.samplers(x, y).into_iter();
        samplers.flat_map(move |sampler| (0..samples).map(move |index| corner + sampler.sample(index).pixel))
    }
}

/// The continuous coordinate of a pixel's centre.
fn centre(x: i32, y: i32) -> DVec2 {
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}

/// Whether hits in two directions lie on one surface.
fn is_same(a: &Facing, q_a: DVec2, b: &Facing, q_b: DVec2) -> bool {
    a.meets(q_b, b.inverse) || b.meets(q_a, a.inverse)
}

/// Whether what is met in a direction lies behind the surface that a pixel's centre meets first.
fn is_behind(first: &Facing, q: DVec2, inverse: f64) -> bool {
    inverse < first.inverse && !first.meets(q, inverse)
}
