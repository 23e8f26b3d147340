//! Ways of things through time: places, turns and sizes at frames, and what comes of several in a row.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, EulerRot};

use crate::SceneError;
use crate::bounds::Bounds;
use crate::curve::{linear, smooth};

/// Where something is in a frame. What the first key leaves out starts at rest: at 0, in its own size; what another leaves out
/// goes on from the key before to the key after.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MoveKey {
    /// When, in frames; need not be whole.
    pub frame: f64,
    /// Where to, in scene units.
    pub translate: Option<DVec3>,
    /// Angles about x, y and z in radians, applied in the order z, x, y; a wheel that turns ten times goes from 0 to 20 pi.
    pub rotate: Option<DVec3>,
    /// Factors along x, y and z.
    pub scale: Option<DVec3>,
}

/// A number at its keys.
type Curve = Vec<(f64, f64)>;

/// A way through some keys: at rest before the first and after the last.
#[derive(Debug, Clone, PartialEq)]
pub struct Moves {
    translate: [Curve; 3],
    rotate: [Curve; 3],
    scale: [Curve; 3],
    is_smooth: bool,
    frames: [f64; 2],
}

/// Bounds on what moves do to a point at distance 1 or less before them.
#[derive(Debug, Clone, Copy)]
struct Pace {
    place: f64,
    scale: f64,
    /// Per frame, as are the following.
    speed: f64,
    turning: f64,
    growth: f64,
}

impl Moves {
    /// Largest frame number.
    const MOST_FRAME: f64 = 1e6;
    /// Largest coordinate.
    const FARTHEST: f64 = 1e12;
    /// Largest angle in radians: some 28,000 turns.
    const MOST_TURN: f64 = 1e7 * std::f64::consts::PI / 180.0;

    /// A way through keys in the order of their frames: straight from one to the next, or smooth, at rest at both ends.
    pub fn new(keys: &[MoveKey], is_smooth: bool) -> Result<Self, SceneError> {
        let fault = |what, value, wanted| Err(SceneError::OutOfRange { what, value, wanted });
        let [Some(first), Some(last)] = [keys.first(), keys.last()] else {
            return fault("number of moves", 0.0, "1 or more");
        };
        for key in keys {
            if !(-Self::MOST_FRAME..=Self::MOST_FRAME).contains(&key.frame) {
                return fault("frame of a move", key.frame, "between -1000000 and 1000000");
            }
            let worst = |value: Option<DVec3>| value.map_or(0.0, |v| v.to_array().into_iter().fold(0.0, larger));
            if !(0.0..=Self::FARTHEST).contains(&worst(key.translate)) {
                return fault("translate of a move", worst(key.translate), "at most 1e12 from the origin");
            }
            if !(0.0..=Self::MOST_TURN).contains(&worst(key.rotate)) {
                return fault("angle of a move in degrees", worst(key.rotate).to_degrees(), "at most 1e7");
            }
        }
        if let Some(pair) = keys.windows(2).find(|pair| pair[0].frame >= pair[1].frame) {
            return fault("frame of a move", pair[1].frame, "later than that of the move before");
        }
        let curves = |value: fn(&MoveKey) -> Option<DVec3>, plain: f64| {
            [0, 1, 2].map(|axis| {
                let of_first = value(first).map_or(plain, |value| value[axis]);
                let others = keys[1..].iter().filter_map(|key| Some((key.frame, value(key)?[axis])));
                let mut curve: Curve = std::iter::once((first.frame, of_first)).chain(others).collect();
                // What never changes is one number, exactly
                if curve.iter().all(|&(_, x)| x == curve[0].1) {
                    curve.truncate(1);
                }
                curve
            })
        };
        let scale = curves(|key| key.scale, 1.0);
        for curve in &scale {
            // A size that goes through 0 would be flat on the way
            let sign = curve[0].1.signum();
            if let Some(&(_, x)) = curve.iter().find(|&&(_, x)| !(1e-6..=1e6).contains(&(sign * x))) {
                return fault("scale of a move", x, "1e-6 to 1e6, or the negative of that in all keys");
            }
        }
        let (translate, rotate) = (curves(|key| key.translate, 0.0), curves(|key| key.rotate, 0.0));
        Ok(Self { translate, rotate, scale, is_smooth, frames: [first.frame, last.frame] })
    }

    /// The first and the last key.
    #[must_use]
    pub fn frames(&self) -> [f64; 2] {
        self.frames
    }

    /// What it does to points at a time in frames: scales, then turns, then moves them.
    fn at(&self, frame: f64) -> DAffine3 {
        let path = if self.is_smooth { smooth } else { linear };
        let of = |curves: &[Curve; 3]| DVec3::from_array([0, 1, 2].map(|axis| path(&curves[axis], frame)));
        map(of(&self.scale), of(&self.rotate), of(&self.translate))
    }

    fn curves(&self) -> impl Iterator<Item = &Curve> {
        self.translate.iter().chain(&self.rotate).chain(&self.scale)
    }

    /// Whether nothing changes between two times.
    fn is_still(&self, [open, close]: [f64; 2]) -> bool {
        self.curves().all(|curve| steepest(curve, [open, close]) == 0.0)
    }

    fn pace(&self, times: [f64; 2]) -> Pace {
        let slope = |curves: &[Curve; 3]| {
            // Between its keys the cubic of `smooth`, whose ends are at most twice as steep as the straight line, is not steeper
            let factor = if self.is_smooth { 2.0 } else { 1.0 };
            DVec3::from_array([0, 1, 2].map(|axis| factor * steepest(&curves[axis], times)))
        };
        let size = |curves: &[Curve; 3]| {
            DVec3::from_array([0, 1, 2].map(|axis| curves[axis].iter().map(|&(_, x)| x).fold(0.0, larger)))
        };
        Pace {
            place: size(&self.translate).length(),
            scale: size(&self.scale).max_element(),
            speed: slope(&self.translate).length(),
            turning: slope(&self.rotate).element_sum(),
            growth: slope(&self.scale).max_element(),
        }
    }
}

/// The larger amount, or NaN if one of the numbers is.
fn larger(most: f64, x: f64) -> f64 {
    if most.is_nan() || x.is_nan() { f64::NAN } else { most.max(x.abs()) }
}

/// The steepest straight line between keys that matter between two times.
fn steepest(curve: &Curve, [open, close]: [f64; 2]) -> f64 {
    let pairs = curve.windows(2).filter(|pair| pair[0].0 < close && pair[1].0 > open);
    pairs.map(|pair| ((pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0)).abs()).fold(0.0, f64::max)
}

/// Scales, then turns about z, x and y in this order, then moves.
pub(crate) fn map(scale: DVec3, rotate: DVec3, translate: DVec3) -> DAffine3 {
    let turn = DQuat::from_euler(EulerRot::YXZ, rotate.y, rotate.x, rotate.z);
    DAffine3::from_scale_rotation_translation(scale, turn, translate)
}

/// A step of a motion.
#[derive(Debug, Clone, PartialEq)]
enum Link {
    Fixed(DAffine3),
    Moves(Arc<Moves>),
}

/// From a thing's own space to the world, at any time: maps and moves in a row, the outermost first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Motion {
    links: Vec<Link>,
}

impl Motion {
    /// None: the thing's own space is the world.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The same after a map that stays.
    #[must_use]
    pub fn placed(mut self, map: DAffine3) -> Self {
        match self.links.last_mut() {
            Some(Link::Fixed(last)) => *last *= map,
            _ => self.links.push(Link::Fixed(map)),
        }
        self
    }

    /// The same after moves.
    #[must_use]
    pub fn moved(mut self, moves: &Arc<Moves>) -> Self {
        self.links.push(Link::Moves(Arc::clone(moves)));
        self
    }

    /// Whether there are any moves in it.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.links.iter().any(|link| matches!(link, Link::Moves(_)))
    }

    /// The first and the last key of all its moves.
    pub(crate) fn frames(&self) -> Option<[f64; 2]> {
        let moves = self.links.iter().filter_map(|link| match link {
            Link::Moves(moves) => Some(moves.frames()),
            Link::Fixed(_) => None,
        });
        moves.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    /// World from the thing's own space at a time in frames.
    pub(crate) fn at(&self, frame: f64) -> DAffine3 {
        self.links.iter().fold(DAffine3::IDENTITY, |map, link| match link {
            Link::Fixed(fixed) => map * *fixed,
            Link::Moves(moves) => map * moves.at(frame),
        })
    }

    /// Where it would stand without its moves.
    pub(crate) fn rest(&self) -> DAffine3 {
        self.links.iter().fold(DAffine3::IDENTITY, |map, link| match link {
            Link::Fixed(fixed) => map * *fixed,
            Link::Moves(_) => map,
        })
    }

    /// Whether nothing changes between two times.
    pub(crate) fn is_still(&self, times: [f64; 2]) -> bool {
        self.links.iter().all(|link| match link {
            Link::Fixed(_) => true,
            Link::Moves(moves) => moves.is_still(times),
        })
    }

    /// Bounds on how far a point within `radius` of the thing's origin comes from the world's, and on its speed per frame.
    fn reach(&self, radius: f64, times: [f64; 2]) -> [f64; 2] {
        self.links.iter().rev().fold([radius, 0.0], |[radius, speed], link| match link {
            Link::Fixed(map) => {
                let [x, y, z] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis];
                let norm = (x.length_squared() + y.length_squared() + z.length_squared()).sqrt();
                [norm * radius + map.translation.length(), norm * speed]
            }
            Link::Moves(moves) => {
                let pace = moves.pace(times);
                let own = pace.speed + (pace.turning * pace.scale + pace.growth) * radius;
                [pace.scale * radius + pace.place, pace.scale * speed + own]
            }
        })
    }

    /// Fails if it squeezes things within `radius` flat, or takes them where numbers end.
    pub(crate) fn check(&self, radius: f64) -> Result<(), SceneError> {
        /// What rays in single precision can still be squared at.
        const FARTHEST: f64 = 1e15;
        let fixed = self.links.iter().all(|link| match link {
            Link::Fixed(map) => map.is_finite() && map.inverse().is_finite(),
            Link::Moves(_) => true,
        });
        if !fixed {
            return Err(SceneError::FlatPlacement);
        }
        let [reach, _] = self.reach(radius, [f64::NEG_INFINITY, f64::INFINITY]);
        if reach <= FARTHEST {
            return Ok(());
        }
        let wanted = "at most 1e15 scene units";
        Err(SceneError::OutOfRange { what: "distance that a moving thing goes", value: reach, wanted })
    }

    /// A box that surely holds, at every time between two, what the box between two corners holds in the thing's own space.
    ///
    /// Its corners are looked at at some times; between them no corner goes farther than its greatest speed allows.
    pub(crate) fn bounds(&self, [low, high]: [DVec3; 2], times: [f64; 2]) -> Bounds {
        const STEPS: [u32; 2] = [8, 512];
        let [open, close] = times;
        let [_, speed] = self.reach(low.abs().max(high.abs()).length(), times);
        // Look so often that the slack is a small part of the thing
        let wanted = 8.0 * speed * (close - open) / (high - low).length();
        let steps = if self.is_still(times) { 0 } else { (wanted.ceil() as u32).clamp(STEPS[0], STEPS[1]) };
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|corner: usize| {
            let pick = |axis: usize| if corner >> axis & 1 == 1 { high[axis] } else { low[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        });
        let step = (close - open) / f64::from(steps.max(1));
        let mut points = Vec::with_capacity(8 * (steps as usize + 1));
        for i in 0..=steps {
            let map = self.at(open + f64::from(i) * step);
            points.extend(corners.map(|corner| map.transform_point3(corner)));
        }
        let slack = if steps == 0 { 0.0 } else { 0.5 * step * speed };
        let of = |side: f64| points.iter().map(move |&point| point + side * slack).collect::<Vec<_>>();
        Bounds::around_exact(&[of(-1.0), of(1.0)].concat())
    }
}

#[cfg(test)]
mod laws;
