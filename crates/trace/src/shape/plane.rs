//! Flat things: the plane y = 0, the square in it, and the discs that close cylinders and cones.

use glam::DVec3;

use super::LocalHit;

pub(super) fn hit(origin: DVec3, direction: DVec3) -> LocalHit {
    let t = -origin.y / direction.y;
    (t > 0.0 && t.is_finite()).then_some((t, DVec3::Y))
}

pub(super) fn hit_square(origin: DVec3, direction: DVec3) -> LocalHit {
    hit(origin, direction).filter(|&(t, _)| {
        let p = origin + t * direction;
        p.x.abs() <= 1.0 && p.z.abs() <= 1.0
    })
}

/// The unit disc at height `y` whose normal is `side` times the y axis.
pub(super) fn hit_disc(origin: DVec3, direction: DVec3, y: f64, side: f64) -> LocalHit {
    let (t, normal) = hit(origin - y * DVec3::Y, direction)?;
    let p = origin + t * direction;
    (p.x * p.x + p.z * p.z <= 1.0).then_some((t, side * normal))
}

/// The nearer of two hits.
pub(super) fn nearer(a: LocalHit, b: LocalHit) -> LocalHit {
    match (a, b) {
        (Some((ta, _)), Some((tb, _))) => {
            if tb < ta {
                b
            } else {
                a
            }
        }
        _ => a.or(b),
    }
}
