//! A surface in one pixel, as the pixel's samples meet it.

use glam::{DVec2, DVec3, Vec3};

use super::facing::Facing;
use super::walk::{Met, Walk};
use crate::sampler::Sampler;
use crate::transport::pixel_size;

/// Points of a surface in one pixel at which is asked whether some lens point sees it, at most.
const POINTS: usize = 8;

/// A surface of a hidden layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surface {
    pub(super) depth: f32,
    /// Its mean colour, as if it filled the pixel.
    pub(super) color: Vec3,
    /// The share of the pixel that it fills and that some lens point sees.
    pub(super) cover: f32,
}

/// What is known of how much of a part is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Seen {
    /// Nothing: its own points have to be asked.
    Unknown,
    /// This share of it.
    Share(f32),
}

impl Seen {
    pub(super) const ALL: Self = Self::Share(1.0);

    /// From points of the part.
    pub(super) fn at<'a>(walk: &Walk, points: impl Iterator<Item = &'a Met>) -> Self {
        let (mut seen, mut asked) = (0.0, 0.0);
        for met in points.take(POINTS) {
            // What lies first on its line is seen by the lens centre
            seen += f32::from(u8::from(met.is_first || walk.sees(met)));
            asked += 1.0_f32;
        }
        Self::Share(seen / asked.max(1.0))
    }
}

/// A surface that may lie in a pixel.
pub(super) struct Part {
    pub(super) facing: Facing,
    /// Whether the pixel's centre meets it; that is where `facing` is then.
    pub(super) is_central: bool,
    pub(super) seen: Seen,
    /// Where each sample meets it.
    pub(super) hits: Vec<Option<Met>>,
}

impl Part {
    pub(super) fn new(facing: Facing, is_central: bool, seen: Seen) -> Self {
        Self { facing, is_central, seen, hits: Vec::new() }
    }

    /// Inverse depth at the pixel's centre, from the plane that touches it; at the rim of what is round that says little, and
    /// it is kept near those that the samples meet.
    pub(super) fn inverse_at(&self, q: DVec2, walk: &Walk) -> f64 {
        if self.is_central {
            return self.facing.inverse;
        }
        let inverses = self.hits.iter().flatten().map(|met| walk.facing(met).inverse);
        let (low, high) = inverses.fold((f64::INFINITY, 0.0_f64), |(low, high), s| (low.min(s), high.max(s)));
        let spread = high - low;
        let plane = self.facing.plane_at(q);
        if plane.is_finite() { plane.clamp((low - spread).max(0.0), high + spread) } else { high }
    }

    /// What it is in pixel (x, y), whose samples come from `samplers`, half by half.
    pub(super) fn surface(&self, q: DVec2, walk: &Walk, samplers: &[Sampler; 2]) -> Surface {
        let (total, size) = (self.hits.len(), pixel_size(walk.camera));
        let color = |(place, met): (usize, &Met)| match &met.hit {
            Some(hit) => {
                let (half, index) = (place / (total / 2), place % (total / 2));
                walk.scene.shade_sample(hit, met.direction, size, (&samplers[half], index as u32))
            }
            None => walk.scene.sky_toward(met.direction),
        };
        let hits = || self.hits.iter().enumerate().filter_map(|(place, met)| Some((place, met.as_ref()?)));
        let sum: DVec3 = hits().map(|hit| color(hit).as_dvec3()).sum();
        let count = hits().count() as f64;
        let share = match self.seen {
            Seen::Share(share) => f64::from(share),
            Seen::Unknown => 0.0,
        };
        Surface {
            depth: (1.0 / self.inverse_at(q, walk)) as f32,
            color: (sum / count).as_vec3(),
            cover: (count / total as f64 * share) as f32,
        }
    }
}

/// The nearest `count` of what is sorted from near to far. Of those that would have to share the last place it goes to the
/// one that the most samples meet before the others.
pub(super) fn nearest(mut parts: Vec<Part>, count: usize) -> Vec<Part> {
    if parts.len() > count {
        let mut crowd = parts.split_off(count - 1);
        let mut firsts = vec![0_usize; crowd.len()];
        for place in 0..crowd[0].hits.len() {
            if let Some(k) = crowd.iter().position(|part| part.hits[place].is_some()) {
                firsts[k] += 1;
            }
        }
        let most = (0..crowd.len()).max_by_key(|&k| (firsts[k], std::cmp::Reverse(k))).unwrap_or(0);
        parts.push(crowd.swap_remove(most));
    }
    parts
}
