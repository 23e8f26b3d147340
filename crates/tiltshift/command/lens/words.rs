//! The report in words.

use std::fmt;

use super::report::{Blur, DepthOfField, Lens, Limits, Number, Picture, Plane, Report};

/// One aligned line: what, and what of it.
fn line(f: &mut fmt::Formatter<'_>, what: &str, text: impl fmt::Display) -> fmt::Result {
    write!(f, "\n  {what:<17} {text}")
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Lens")?;
        self.lens.fmt(f)?;
        self.picture.fmt(f)?;
        f.write_str("\n\nPlane of sharp focus")?;
        self.plane_of_focus.fmt(f)?;
        f.write_str("\n\nDepth of field")?;
        if self.lens.aperture_radius_mm == 0.0 {
            line(f, "pinhole", "everything is sharp")?;
        } else {
            self.depth_of_field.fmt(f)?;
            f.write_str("\n\nBlur")?;
            self.blur.fmt(f)?;
        }
        Ok(())
    }
}

impl fmt::Display for Lens {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        line(f, "focal length", millimetres(self.focal_length_mm))?;
        if self.aperture_radius_mm == 0.0 {
            line(f, "aperture", "a pinhole")?;
        } else {
            let (number, effective) = (significant(self.f_number.0, 3), significant(self.effective_f_number.0, 3));
            let radius = millimetres(self.aperture_radius_mm);
            line(f, "aperture", format_args!("f/{number}, radius {radius}; effective f/{effective} at this focus"))?;
        }
        line(f, "image distance", format_args!("{} from lens to sensor", millimetres(self.image_distance_mm)))?;

        // Signs in words, and the sum only where there are two
        let tilt = turn("tilt", self.tilt_deg, "down", "up");
        let swing = turn("swing", self.swing_deg, "right", "left");
        match (&tilt, &swing) {
            (None, None) => line(f, "lens axis", "neither tilted nor swung")?,
            (Some(turn), None) | (None, Some(turn)) => line(f, "lens axis", turn)?,
            (Some(tilt), Some(swing)) => {
                line(f, "lens axis", format_args!("{tilt}, {swing}; {} in total", degrees(self.total_tilt_deg)))?;
            }
        }
        if let Some(wish) = self.tilt_follows_from {
            write!(f, " (to suit the {wish})")?;
        }
        Ok(())
    }
}

impl fmt::Display for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([width, height], [across, down]) = (self.size_px, self.field_of_view_deg);
        line(f, "picture", format_args!("{width} x {height} px, {} x {}", number(across, 2), degrees(down)))?;
        let [right, rise] = self.shift_mm;
        if [right, rise] != [0.0, 0.0] {
            line(f, "shift", sides([right, rise], &millimetres, ["left", "right", "down", "up"]))?;
        }
        Ok(())
    }
}

impl fmt::Display for Plane {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.depth_on_axis_m {
            None => line(f, "on the axis", "behind the camera: nothing ahead is sharp there")?,
            Some(Number(depth)) => line(f, "on the axis", format_args!("sharp at {}", metres(depth)))?,
        }
        if !self.is_in_the_picture {
            line(f, "in the picture", "nowhere: the plane is behind the camera for every pixel")?;
        }
        let Some(hinge) = &self.hinge else {
            return line(f, "angle", "parallel to the sensor: no hinge, no Scheimpflug line");
        };
        line(f, "angle", format_args!("{} from the sensor", degrees(self.angle_from_sensor_deg)))?;
        if let Some(angle) = &self.nakane {
            let (theta, distance) = (degrees(angle.theta_deg), metres(angle.distance_m));
            line(f, "theta and U", format_args!("{theta} from the optical axis at {distance} (Nakane et al.)"))?;
        }

        // The lines that a tilt draws
        let place = sides(hinge.nearest_point_m, &metres, PLACES);
        let is_oblique = place.contains(" and ");
        if is_oblique {
            let distance = metres(hinge.distance_m);
            line(f, "hinge", format_args!("{distance} from the lens; its nearest point is {place} it"))?;
        } else {
            line(f, "hinge", format_args!("{place} the lens"))?;
        }
        if let Some(scheimpflug) = &self.scheimpflug_line {
            let [x, y, z] = scheimpflug.nearest_point_mm.map(|part| 1e-3 * part);
            let (place, behind) = (sides([x, y], &metres, PLACES), millimetres(-1e3 * z));
            line(
                f,
                "Scheimpflug line",
                format_args!("{place} the optical axis, in the sensor's plane {behind} behind"),
            )?;
        }
        if let Some([from, to]) = self.vanishing_line_px {
            let [from, to] = [from, to].map(|[x, y]| format!("({}, {})", number(x, 1), number(y, 1)));
            let beyond = sides(hinge.nearest_point_m.map(|part| -part), &|_| String::new(), PLACES);
            let beyond = beyond.replace("  ", " ");
            line(f, "vanishing line", format_args!("in the picture, from {from} to {to} px: focused at infinity;"))?;
            line(f, "", format_args!("{} it the plane of focus is behind the camera", beyond.trim()))?;
        }
        let [x, y, z] = self.w_per_m.map(|part| number(part, 4));
        line(f, "w", format_args!("({x}, {y}, {z}) per metre; sharp is w . P = 1 (x right, y up, z depth)"))
    }
}

impl fmt::Display for DepthOfField {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let coc = self.coc_radius_px;
        write!(f, " (sharp: a circle of confusion of at most {coc} px radius)")?;
        line(f, "", format_args!("{:>12}{:>12}{:>12}", "near", "sharpest", "far"))?;
        let rows = [
            ("on the axis", &self.on_axis),
            ("top", &self.top),
            ("bottom", &self.bottom),
            ("left", &self.left),
            ("right", &self.right),
        ];
        for (place, limits) in rows {
            line(f, place, limits)?;
        }
        if let (Some(half_width), Some(Number(depth))) = (self.wedge_half_width_m, self.on_axis.sharp_m) {
            let (half_width, depth) = (metres(half_width), metres(depth));
            line(
                f,
                "wedge",
                format_args!("{half_width} to each side of the plane at {depth}, parallel to the sensor"),
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.near_m.is_none() {
            return write!(f, "{:>12}", "nothing: the plane is behind the camera");
        }
        for depth in [self.near_m, self.sharp_m, self.far_m] {
            write!(f, "{:>12}", depth.map_or("behind".to_owned(), |depth| metres(depth.0)))?;
        }
        Ok(())
    }
}

impl fmt::Display for Blur {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sky = number(self.largest_of_sky_diameter_px, 1);
        if self.largest_of_sky_diameter_px < 0.05 {
            line(f, "sky", "sharp")?;
        } else {
            line(f, "sky", format_args!("up to {sky} px diameter"))?;
        }
        let Some(scene) = &self.scene else {
            return line(f, "kernel", "give --nearest to learn what the filter would take");
        };
        let (nearest, largest) = (metres(scene.nearest_m), number(scene.largest_diameter_px, 1));
        line(f, "scene", format_args!("up to {largest} px diameter from {nearest} to infinity"))?;
        let reason = scene.kernel_reason.trim_start_matches(&scene.kernel).trim_start_matches(" kernel: ");
        line(f, "kernel", format_args!("{}: {reason}", scene.kernel))?;
        let (columns, rows) = (scene.overscan_columns_px.0, scene.overscan_rows_px.0);
        if columns.max(rows).is_finite() {
            line(
                f,
                "overscan",
                format_args!("{columns} columns and {rows} rows on each side hold all that the lens sees"),
            )
        } else {
            line(f, "overscan", "no margin is wide enough")
        }
    }
}

/// How to say left, right, below and above of something.
const PLACES: [&str; 4] = ["left of", "right of", "below", "above"];

/// A vector (right, up) in words, `names` for its four directions.
fn sides([x, y]: [f64; 2], length: &dyn Fn(f64) -> String, names: [&str; 4]) -> String {
    const ROUNDING: f64 = 1e-9; // of the longer part
    let least = ROUNDING * x.abs().max(y.abs());
    let side = |part: f64, [minus, plus]: [&str; 2]| {
        (part.abs() > least).then(|| format!("{} {}", length(part.abs()), if part < 0.0 { minus } else { plus }))
    };
    let parts = [side(y, [names[2], names[3]]), side(x, [names[0], names[1]])];
    parts.into_iter().flatten().collect::<Vec<_>>().join(" and ")
}

/// An angle with its direction; `None` for less than half of the last digit that is shown.
fn turn(what: &str, angle: f64, positive: &str, negative: &str) -> Option<String> {
    let direction = if angle > 0.0 { positive } else { negative };
    (angle.abs() >= 0.005).then(|| format!("{what} {} {direction}", degrees(angle.abs())))
}

fn degrees(angle: f64) -> String {
    format!("{} degrees", number(angle, 2))
}

fn millimetres(length: f64) -> String {
    format!("{} mm", significant(length, 5))
}

fn metres(depth: f64) -> String {
    if depth.is_infinite() { "infinity".to_owned() } else { format!("{} m", significant(depth, 4)) }
}

/// A number to so many decimals, without a minus before zero.
fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.chars().all(|digit| matches!(digit, '0' | '.')) => digits.to_owned(),
        _ => text,
    }
}

/// A number to so many significant digits, without zeros at the end of its fraction.
fn significant(value: f64, digits: i32) -> String {
    let magnitude = if value == 0.0 { 0 } else { value.abs().log10().floor().clamp(-9.0, 15.0) as i32 };
    let text = number(value, (digits - 1 - magnitude).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
