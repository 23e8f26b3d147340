//! Points that stand for a whole iris.

use glam::{DVec2, DVec3};
use optics::Camera;

/// Rings of points: share of the radius, and how many.
const RINGS: [(f64, u32); 3] = [(1.0, 24), (0.66, 16), (0.33, 8)];

/// 48 points of the camera's iris in world space, half of them on its rim.
///
/// The iris maps squares around the centre of the unit square onto rings of its own outline, whatever its shape.
pub(super) fn lens_points(camera: &Camera) -> Vec<DVec3> {
    let ring = |(share, count): (f64, u32)| {
        (0..count).map(move |i| {
            let along = 4.0 * (f64::from(i) + 0.5) / f64::from(count);
            let (side, t) = (along.floor(), 2.0 * along.fract() - 1.0);
            let edge = match side as u32 {
                0 => DVec2::new(1.0, t),
                1 => DVec2::new(-t, 1.0),
                2 => DVec2::new(-1.0, -t),
                _ => DVec2::new(t, -1.0),
            };
            // Stay inside [0, 1)^2
            (DVec2::splat(0.5) + 0.5 * share * edge).min(DVec2::splat(1.0 - 1e-9))
        })
    };
    RINGS.into_iter().flat_map(ring).map(|u| camera.pose.point_to_world(camera.iris.point(u))).collect()
}

#[cfg(test)]
mod tests {
    use optics::{ApertureShape, Film, Focus, Iris, Pose};

    use super::*;

    #[test]
    fn half_of_them_lie_on_the_rim_of_any_iris() {
        for shape in [ApertureShape::Disc, ApertureShape::polygon(6, 0.2).unwrap()] {
            let camera = Camera {
                pose: Pose::IDENTITY,
                film: Film::from_fov(1.0, 4, 4).unwrap(),
                focus: Focus::at_depth(1.0).unwrap(),
                iris: Iris::new(DVec3::new(0.1, -0.4, 1.0), 2.0, shape).unwrap(),
            };
            let points = lens_points(&camera);
            assert_eq!(points.len(), 48);
            let mut on_rim = 0;
            for p in points {
                let p = camera.pose.point_to_camera(p);
                assert!(p.dot(camera.iris.normal()).abs() < 1e-12);
                let place = DVec2::new(p.dot(camera.iris.e1()), p.dot(camera.iris.e2())) / 2.0;
                assert!(shape.contains(0.999 * place));
                on_rim += usize::from(!shape.contains(1.001 * place));
            }
            assert_eq!(on_rim, 24);
        }
    }
}
