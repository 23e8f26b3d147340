//! The closed cylinder of radius 1, y from 0 to 1.

use glam::DVec3;

use super::{LocalHit, plane, quadratic};

pub(super) fn hit(origin: DVec3, direction: DVec3) -> LocalHit {
    let (o, d) = (origin, direction);
    let mut nearest = plane::nearer(plane::hit_disc(o, d, 0.0, -1.0), plane::hit_disc(o, d, 1.0, 1.0));
    let roots = quadratic::roots(d.x * d.x + d.z * d.z, o.x * d.x + o.z * d.z, o.x * o.x + o.z * o.z - 1.0);
    for t in roots.into_iter().flatten() {
        let p = o + t * d;
        if t > 0.0 && (0.0..=1.0).contains(&p.y) {
            nearest = plane::nearer(nearest, Some((t, DVec3::new(p.x, 0.0, p.z))));
        }
    }
    nearest
}
