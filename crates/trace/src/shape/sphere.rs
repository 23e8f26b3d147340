//! The unit ball.

use glam::DVec3;

use super::{LocalHit, quadratic};

pub(super) fn hit(origin: DVec3, direction: DVec3) -> LocalHit {
    let [t0, t1] = quadratic::roots(direction.length_squared(), origin.dot(direction), origin.length_squared() - 1.0)?;
    let (near, far) = if t0 < t1 { (t0, t1) } else { (t1, t0) };
    let t = if near > 0.0 { near } else { far };
    (t > 0.0).then(|| (t, origin + t * direction))
}
