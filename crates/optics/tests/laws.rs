//! Laws of the tilted thin lens, for random lenses: imaging, Scheimpflug, hinge, rays, and both forms of eq. (5).

mod random_lens;

use glam::{DVec2, DVec3};
use optics::{Focus, Footprint, Reading, SpaceLine};
use proptest::prelude::*;
use random_lens::{lens, lens_camera, q_at, raw_camera, tilted_lens, unit_square};

/// Rounding of f64 through a handful of operations on numbers of very different size.
const ROUNDING: f64 = 1e-9;

fn on_line(line: &SpaceLine, t: f64) -> DVec3 {
    line.point + t * line.direction
}

proptest! {
    #[test]
    fn the_plane_of_focus_is_imaged_onto_the_sensor(lens in lens(), x in -0.5..0.5f64, y in -0.5..0.5f64) {
        let q1 = DVec3::new(x, y, 1.0);
        let w = lens.focus().inverse_depth(q1.truncate());
        prop_assume!(w.abs() > 1e-6);
        // Solve 1/(n.P) + 1/(k n.P) = 1/F for the image -kP of the sharp point P; it must lie at z = -v
        let p = q1 / w;
        let along = lens.axis().dot(p);
        let k = 1.0 / (along / lens.focal_length() - 1.0);
        prop_assert!((k * p.z / lens.image_distance() - 1.0).abs() < ROUNDING);
    }

    #[test]
    fn sensor_lens_and_plane_of_focus_meet_in_one_line(lens in tilted_lens(), t in -1.0..1.0f64) {
        let line = lens.scheimpflug_line().unwrap();
        let p = on_line(&line, t * line.distance());
        let size = p.length();
        prop_assert!((p.z + lens.image_distance()).abs() < ROUNDING * size);
        prop_assert!(lens.axis().dot(p).abs() < ROUNDING * size);
        prop_assert!((lens.focus().w().dot(p) - 1.0).abs() < ROUNDING * size / lens.focal_length());
    }

    #[test]
    fn the_hinge_lies_on_the_front_focal_plane_at_f_over_sin_tilt(lens in tilted_lens(), t in -1.0..1.0f64) {
        let hinge = lens.focus().hinge().unwrap();
        let p = on_line(&hinge, t * hinge.distance());
        prop_assert_eq!(p.z, 0.0);
        prop_assert!((lens.axis().dot(p) / lens.focal_length() - 1.0).abs() < ROUNDING);
        prop_assert!((lens.focus().w().dot(p) - 1.0).abs() < ROUNDING);
        let merklinger = lens.focal_length() / lens.total_tilt().sin();
        prop_assert!((lens.focus().hinge_distance() / merklinger - 1.0).abs() < ROUNDING);
        prop_assert!((hinge.distance() / merklinger - 1.0).abs() < ROUNDING);
    }

    #[test]
    fn focus_is_at_infinity_on_the_vanishing_line(lens in tilted_lens(), t in -1.0..1.0f64) {
        let focus = lens.focus();
        let line = focus.vanishing_line().unwrap();
        let q = line.point + t * line.direction;
        prop_assert!(focus.inverse_depth(q).abs() < ROUNDING * focus.w().length() * (1.0 + q.length()));
    }

    #[test]
    fn every_ray_of_a_pixel_meets_the_plane_of_focus_in_one_point(
        camera in raw_camera(), place in unit_square(), u in unit_square(),
    ) {
        let q = q_at(&camera.film, place);
        let w = camera.focus.inverse_depth(q);
        prop_assume!(w.abs() > 1e-3);
        let Some(ray) = camera.ray(q, DVec2::from_array(u), 0.0) else { return Ok(()) };
        prop_assert_eq!(ray.weight, 1.0);
        // The ray passes the sharp point (q, 1)/w at parameter 1/w, also where that is behind the camera
        let sharp = q.extend(1.0) / w;
        prop_assert!((ray.origin + ray.direction / w - sharp).length() < ROUNDING * sharp.length());
        prop_assert!((camera.focus.w().dot(sharp) - 1.0).abs() < ROUNDING);
        // It starts on the iris
        prop_assert!(camera.iris.normal().dot(ray.origin).abs() < 1e-15);
    }

    #[test]
    fn the_traced_ray_and_both_closed_forms_agree(
        camera in raw_camera(), place in unit_square(), u in unit_square(), log_z in -1.0..5.0f64,
    ) {
        let q = q_at(&camera.film, place);
        let z = log_z.exp();
        let Some(ray) = camera.ray(q, DVec2::from_array(u), 0.0) else { return Ok(()) };
        let p_camera = ray.origin + ray.direction * ((z - ray.origin.z) / ray.direction.z);
        let p = p_camera.truncate() / p_camera.z;
        let gathered = camera.seen_through(q, 1.0 / z, ray.origin).unwrap();
        let scattered = camera.lands_at(p, 1.0 / z, ray.origin).unwrap();
        prop_assert!((gathered - p).length() < ROUNDING, "{gathered} {p}");
        prop_assert!((scattered - q).length() < ROUNDING, "{scattered} {q}");
    }

    #[test]
    fn a_real_lens_agrees_as_well(
        (lens, camera) in lens_camera(), place in unit_square(), u in unit_square(), depth in 1.0..100.0f64,
    ) {
        let q = q_at(&camera.film, place);
        // Depths from the length of the lens outwards
        let z = depth * camera.iris.radius() + depth * 0.1;
        let ray = camera.ray(q, DVec2::from_array(u), 0.0).unwrap();
        let p_camera = ray.origin + ray.direction * ((z - ray.origin.z) / ray.direction.z);
        let p = p_camera.truncate() / p_camera.z;
        prop_assert!((camera.seen_through(q, 1.0 / z, ray.origin).unwrap() - p).length() < ROUNDING);
        prop_assert!((camera.lands_at(p, 1.0 / z, ray.origin).unwrap() - q).length() < ROUNDING);
        // For an iris in the lens plane w.L = -l_z/v, the shorter denominator of eq. (5)
        let short = -ray.origin.z / lens.image_distance();
        prop_assert!((camera.focus.w().dot(ray.origin) - short).abs() < ROUNDING);
    }

    #[test]
    fn the_footprint_is_eq_5_over_the_opening(
        camera in raw_camera(), place in unit_square(), u in unit_square(), inverse_depth in 0.0..3.0f64,
    ) {
        let at = q_at(&camera.film, place);
        let unit = camera.iris.shape().sample(DVec2::from_array(u));
        let lens_point = camera.iris.point(DVec2::from_array(u));
        if let Some(p) = camera.seen_through(at, inverse_depth, lens_point) {
            let offset = Footprint::new(&camera, Reading::Gather, at, inverse_depth).offset(unit).unwrap();
            prop_assert!((at + offset - p).length() < ROUNDING);
        }
        if let Some(q) = camera.lands_at(at, inverse_depth, lens_point) {
            let offset = Footprint::new(&camera, Reading::Scatter, at, inverse_depth).offset(unit).unwrap();
            prop_assert!((at + offset - q).length() < ROUNDING);
        }
    }

    #[test]
    fn gathering_through_an_upright_iris_is_an_exact_disc(
        camera in raw_camera(), place in unit_square(), inverse_depth in 0.0..3.0f64, u in unit_square(),
    ) {
        let camera = optics::Camera {
            iris: optics::Iris::upright(camera.iris.radius(), camera.iris.shape()).unwrap(), ..camera
        };
        let q = q_at(&camera.film, place);
        let footprint = Footprint::new(&camera, Reading::Gather, q, inverse_depth);
        let unit = camera.iris.shape().sample(DVec2::from_array(u));
        prop_assert_eq!(footprint.offset(unit).unwrap(), footprint.disc_offset(unit));
        let radius = camera.coc_radius_px(q, inverse_depth).abs() / camera.film.pixels_per_q().max_element();
        prop_assert!((footprint.disc_radius() - radius).abs() < 1e-15);
    }

    #[test]
    fn points_at_the_limits_of_the_wedge_blur_to_its_circle_of_confusion(
        (_, camera) in lens_camera(), place in unit_square(), coc in 0.1..5.0f64,
    ) {
        let wedge = camera.wedge(coc).unwrap();
        let q = q_at(&camera.film, place);
        let Some((near, far)) = wedge.limits(q) else {
            prop_assert!(camera.coc_radius_px(q, 0.0) > coc);
            return Ok(());
        };
        let tolerance = ROUNDING * (1.0 + camera.coc_radius_px(q, 0.0).abs());
        prop_assert!((camera.coc_radius_px(q, 1.0 / near) - coc).abs() < tolerance);
        if far.is_finite() {
            prop_assert!((camera.coc_radius_px(q, 1.0 / far) + coc).abs() < tolerance);
        } else {
            prop_assert!(camera.coc_radius_px(q, 0.0) >= -coc - tolerance);
        }
        // The limits are planes through the hinge
        let hinge = camera.focus.hinge().unwrap().point;
        for plane in [wedge.near_plane().unwrap(), wedge.far_plane().unwrap()] {
            prop_assert!((plane.w().dot(hinge) - 1.0).abs() < ROUNDING);
        }
        // At the hyperfocal depth they stand J away from the plane of focus, measured across the hinge
        let (across, hyperfocal) = (hinge / hinge.length(), wedge.hyperfocal_depth());
        let place_on = |plane: Focus| (1.0 - plane.w().z * hyperfocal) / plane.w().dot(across);
        let apart = place_on(wedge.far_plane().unwrap()) - place_on(camera.focus);
        prop_assert!((apart / wedge.half_width(hyperfocal) - 1.0).abs() < 1e-6);
        prop_assert!((wedge.half_width(hyperfocal) / camera.focus.hinge_distance() - 1.0).abs() < ROUNDING);
    }
}
