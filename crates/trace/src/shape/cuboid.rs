//! The cube [-1, 1]^3.

use glam::DVec3;

use super::LocalHit;

pub(super) fn hit(origin: DVec3, direction: DVec3) -> LocalHit {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut enter_normal, mut leave_normal) = (DVec3::ZERO, DVec3::ZERO);
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        // A line along the slab is in it everywhere or nowhere
        if d == 0.0 {
            if o.abs() > 1.0 {
                return None;
            }
            continue;
        }
        let side = d.signum();
        let (t0, t1) = ((-side - o) / d, (side - o) / d);
        if t0 > enter {
            (enter, enter_normal) = (t0, -side * DVec3::AXES[axis]);
        }
        if t1 < leave {
            (leave, leave_normal) = (t1, side * DVec3::AXES[axis]);
        }
    }
    if enter > leave || leave <= 0.0 {
        return None;
    }
    Some(if enter > 0.0 { (enter, enter_normal) } else { (leave, leave_normal) })
}
