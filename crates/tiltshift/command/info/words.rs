//! The report in words.

use std::fmt::{self, Display};
use std::path::Path;

use rgbd::{Choice, Inspection, LensAttributes, PartSurvey, Primaries, Understood};

/// No more lines than this are spent on the layers of a part.
const MOST_LAYERS: usize = 24;

/// An inspection, to be written in words.
pub(super) struct Words<'a> {
    pub(super) path: &'a Path,
    pub(super) inspection: &'a Inspection,
}

/// One aligned line: what, and what of it.
fn line(f: &mut fmt::Formatter<'_>, what: &str, text: impl Display) -> fmt::Result {
    write!(f, "\n  {what:<14} {text}")
}

impl Display for Words<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Inspection { survey, head, lens, kind, frame, picture, picture_verdict, .. } = self.inspection;
        write!(f, "{}", shown(&self.path.display().to_string()))?;
        if let Some(kind) = kind {
            line(f, "written by", format_args!("tiltshift, as a {kind}"))?;
        }
        line(f, "display window", survey.display)?;
        if head.pixel_aspect != 1.0 {
            line(f, "pixel aspect", head.pixel_aspect)?;
        }
        if head.primaries != Primaries::REC709 {
            let Primaries { red, green, blue, white } = head.primaries;
            line(f, "primaries", format_args!("red {red:?}, green {green:?}, blue {blue:?}, white {white:?}"))?;
        }
        if !survey.views.is_empty() {
            line(f, "views", shown(&survey.views.join(", ")))?;
        }
        for part in &survey.parts {
            describe_part(f, part)?;
        }

        // What would be made of it
        f.write_str("\n\nColour and depth")?;
        match (frame, picture) {
            (Ok(understood), _) => describe_frame(f, understood)?,
            (Err(error), picture) => {
                if let Some(choice) = picture {
                    describe_choice(f, choice)?;
                }
                line(f, "filter", format_args!("refuses it: {}", shown(&error.to_string())))?;
                if let Some(verdict) = picture_verdict {
                    line(f, "", "red, green and blue are the same everywhere: if that is depth, name it with --depth")?;
                    line(f, "flat surfaces", verdict)?;
                }
            }
        }

        // What took the picture
        f.write_str("\n\nCamera")?;
        if let Some(camera) = &head.camera {
            let (min, max) = (camera.film.min(), camera.film.max());
            let [width, height] = [(min.x, max.x), (min.y, max.y)].map(|(a, b)| (b.atan() - a.atan()).to_degrees());
            line(f, "camera", format_args!("tiltshift's own, {width:.2} x {height:.2} degrees"))?;
        }
        describe_lens(f, lens)?;
        match head.metres_per_unit {
            Some(metres) => line(f, "unit of depth", format_args!("{metres} m")),
            None => line(f, "unit of depth", "not stated; filter takes it as 1 m (--metres-per-unit)"),
        }
    }
}

fn describe_part(f: &mut fmt::Formatter<'_>, part: &PartSurvey) -> fmt::Result {
    let name = part.name.as_deref().map_or_else(String::new, |name| format!(" {}", shown(name)));
    write!(f, "\n\nPart{name}")?;
    if let Some(view) = &part.view {
        line(f, "view", shown(view))?;
    }
    line(f, "data window", part.window)?;
    let deep = if part.deep { "deep " } else { "" };
    let levels = if part.has_levels { ", with smaller levels" } else { "" };
    match part.tile {
        None => line(f, "stored as", format_args!("{deep}scan lines, compression {}", part.compression))?,
        Some([width, height]) => {
            let tiles = format_args!("{deep}tiles of {width}x{height}{levels}, compression {}", part.compression);
            line(f, "stored as", tiles)?;
        }
    }

    // Channels of one layer and type share a line
    let mut layers: Vec<(String, String, Vec<&str>)> = Vec::new();
    for channel in &part.channels {
        let (layer, base) = channel.name.rsplit_once('.').unwrap_or(("", &channel.name));
        let kind = if channel.subsampled { format!("{}, subsampled", channel.kind) } else { channel.kind.to_string() };
        match layers.last_mut() {
            Some((last, last_kind, bases)) if last == layer && *last_kind == kind => bases.push(base),
            _ => layers.push((layer.to_owned(), kind, vec![base])),
        }
    }
    for (i, (layer, kind, bases)) in layers.iter().take(MOST_LAYERS).enumerate() {
        let what = if i == 0 { "channels" } else { "" };
        let dot = if layer.is_empty() { "" } else { "." };
        line(f, what, format_args!("{}{dot}{} ({kind})", shown(layer), shown(&bases.join(" "))))?;
    }
    match layers.len().checked_sub(MOST_LAYERS) {
        None | Some(0) => Ok(()),
        Some(more) => line(f, "", format_args!("and {more} more layers")),
    }
}

fn describe_choice(f: &mut fmt::Formatter<'_>, choice: &Choice) -> fmt::Result {
    if let Some(view) = &choice.view {
        line(f, "view", shown(view))?;
    }
    line(f, "colour", shown(&choice.color.join(", ")))?;
    if let Some(depth) = &choice.depth {
        line(f, "depth", shown(depth))?;
    }
    if !choice.hidden.is_empty() {
        line(f, "hidden layers", choice.hidden.join(", "))?;
    }
    line(f, "because", shown(&choice.reason))
}

fn describe_frame(f: &mut fmt::Formatter<'_>, understood: &Understood) -> fmt::Result {
    describe_choice(f, &understood.choice)?;
    let depth = understood.depth;
    match depth.range {
        Some([near, far]) => {
            line(f, "depth range", format_args!("{} to {} ({})", number(near), number(far), understood.depth_kind))?;
        }
        None => line(f, "depth range", "no pixel has a finite depth")?,
    }
    let all = (depth.finite + depth.infinite + depth.unknown).max(1);
    let share = |pixels: u64| 100.0 * pixels as f64 / all as f64;
    let stored = |value: Option<f32>| value.map_or_else(String::new, |value| format!(", stored as {}", number(value)));
    let pixels = |pixels: u64, value| match pixels {
        0 => "none".to_owned(),
        1 => format!("one pixel{}", stored(value)),
        _ => format!("{pixels} pixels ({:.1} %){}", share(pixels), stored(value)),
    };
    line(f, "background", pixels(depth.infinite, depth.background))?;
    line(f, "holes", pixels(depth.unknown, depth.hole))?;
    if let Some(verdict) = understood.verdict {
        line(f, "flat surfaces", verdict)?;
    }
    if let Some(deep) = understood.deep {
        line(f, "samples", format_args!("{}, none in {} pixels; {deep}", deep.samples, deep.empty))?;
    }
    Ok(())
}

/// What the standard attributes say, or what would be asked for.
fn describe_lens(f: &mut fmt::Formatter<'_>, lens: &LensAttributes) -> fmt::Result {
    let mm = |x: f32| format!("{x} mm");
    let known = [
        ("focal length", lens.focal_length_mm.map(mm)),
        ("image distance", lens.image_distance_mm.map(mm)),
        ("aperture", lens.f_number.map(|n| format!("f/{n}"))),
        ("focus", lens.focus_distance_m.map(|x| format!("{x} m"))),
        ("sensor", lens.sensor_mm.map(|[width, height]| format!("{width} x {height} mm"))),
        ("sensor offset", lens.sensor_offset_um.map(|[x, y]| format!("{x}, {y} microns, right and down"))),
        ("field of view", lens.horizontal_fov_deg.map(|degrees| format!("{degrees} degrees across"))),
        ("clipping", lens.near.zip(lens.far).map(|(near, far)| format!("{near} to {far}"))),
        ("worldToCamera", lens.world_to_camera.map(|_| "stated".to_owned())),
        ("worldToNDC", lens.world_to_ndc.map(|_| "stated".to_owned())),
    ];
    for (what, text) in known {
        if let Some(text) = text {
            line(f, what, text)?;
        }
    }
    let sees = lens.horizontal_fov_deg.is_some() || (lens.focal_length_mm.is_some() && lens.sensor_mm.is_some());
    if !sees && lens.world_to_ndc.is_none() {
        line(f, "field of view", "not stated: filter needs --focal-length and --sensor-width, or --fov")?;
    }
    Ok(())
}

/// A number without a row of zeros.
fn number(value: f32) -> String {
    if value.is_finite() && value.abs() >= 1e7 { format!("{value:e}") } else { value.to_string() }
}

/// Text of a file, with what a terminal would obey made visible.
fn shown(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { c.escape_default().to_string() } else { c.to_string() }).collect()
}
