//! The closed cone with a base of radius 1 at y = 0 and its tip at y = 1.

use glam::DVec3;

use super::{LocalHit, plane, quadratic};

pub(super) fn hit(origin: DVec3, direction: DVec3) -> LocalHit {
    let (o, d) = (origin, direction);
    let mut nearest = plane::hit_disc(o, d, 0.0, -1.0);
    // x^2 + z^2 = (1 - y)^2; the second nappe above the tip is cut off
    let down = 1.0 - o.y;
    let roots = quadratic::roots(
        d.x * d.x + d.z * d.z - d.y * d.y,
        o.x * d.x + o.z * d.z + down * d.y,
        o.x * o.x + o.z * o.z - down * down,
    );
    for t in roots.into_iter().flatten() {
        let p = o + t * d;
        if t > 0.0 && (0.0..=1.0).contains(&p.y) {
            let normal = DVec3::new(p.x, 1.0 - p.y, p.z);
            // The tip itself has no normal: let it look up
            let normal = if normal == DVec3::ZERO { DVec3::Y } else { normal };
            nearest = plane::nearer(nearest, Some((t, normal)));
        }
    }
    nearest
}
