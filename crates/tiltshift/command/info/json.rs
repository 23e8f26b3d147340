//! The report as JSON.

use std::path::Path;

use rgbd::{Choice, DepthSummary, DepthVerdict, Inspection, LensAttributes, PartSurvey, PixelWindow, Understood};
use serde_json::{Value, json};

/// All that there is to say.
pub(super) fn report(path: &Path, inspection: &Inspection) -> Value {
    let Inspection { survey, head, lens, notes, kind, frame, picture, picture_is_grey, picture_verdict } = inspection;
    let p = &head.primaries;
    let primaries = [p.red, p.green, p.blue, p.white].map(|xy| xy.map(number));
    json!({
        "file": path.display().to_string(),
        "written_by_tiltshift_as": kind,
        "display_window": window(survey.display),
        "pixel_aspect": number(head.pixel_aspect),
        "primaries_xy": primaries,
        "metres_per_unit": head.metres_per_unit,
        "views": survey.views,
        "parts": survey.parts.iter().map(part).collect::<Vec<_>>(),
        "frame": frame.as_ref().ok().map(understood),
        "refused_because": frame.as_ref().err().map(ToString::to_string),
        "picture": picture.as_ref().map(choice),
        "picture_is_grey": picture_is_grey,
        "picture_as_depth": picture_verdict.as_ref().map(verdict),
        "camera": head.camera,
        "lens_attributes": attributes(lens),
        "notes": notes,
    })
}

fn part(part: &PartSurvey) -> Value {
    let channels = part.channels.iter().map(
        |channel| json!({ "name": channel.name, "type": channel.kind.to_string(), "subsampled": channel.subsampled }),
    );
    json!({
        "name": part.name,
        "view": part.view,
        "data_window": window(part.window),
        "deep": part.deep,
        "compression": part.compression,
        "tile": part.tile,
        "has_levels": part.has_levels,
        "channels": channels.collect::<Vec<_>>(),
    })
}

fn understood(understood: &Understood) -> Value {
    let DepthSummary { range, finite, infinite, unknown, background, hole } = understood.depth;
    let mut value = choice(&understood.choice);
    value["window"] = window(understood.window);
    value["depth_type"] = json!(understood.depth_kind.to_string());
    value["depth_range"] = json!(range.map(|range| range.map(number)));
    value["pixels_of_finite_depth"] = json!(finite);
    value["pixels_infinitely_far"] = json!(infinite);
    value["pixels_of_unknown_depth"] = json!(unknown);
    value["background_stored_as"] = json!(background.map(number));
    value["holes_stored_as"] = json!(hole.map(number));
    value["flat_surfaces_say"] = json!(understood.verdict.as_ref().map(verdict));
    value["deep"] = json!(understood.deep.map(|deep| json!({
        "samples": deep.samples,
        "most_samples_in_a_pixel": deep.most,
        "pixels_without_samples": deep.empty,
        "pixels_with_merged_surfaces": deep.merged,
        "volumes": deep.volumes,
    })));
    value
}

/// What flat surfaces say of the numbers.
pub(super) fn verdict(verdict: &DepthVerdict) -> Value {
    json!({
        "convention": verdict.convention.map(|convention| convention.to_string()),
        "confidence": number(verdict.confidence),
        "patches_that_agree": verdict.patches[0],
        "patches_that_contradict": verdict.patches[1],
        "is_normalised": verdict.is_normalised,
        "knows_field_of_view": verdict.knows_film,
    })
}

fn choice(choice: &Choice) -> Value {
    let Choice { view, color, depth, hidden, reason, .. } = choice;
    json!({ "view": view, "color": color, "depth": depth, "hidden_layers": hidden, "reason": reason })
}

fn attributes(lens: &LensAttributes) -> Value {
    json!({
        "focal_length_mm": lens.focal_length_mm.map(number),
        "image_distance_mm": lens.image_distance_mm.map(number),
        "f_number": lens.f_number.map(number),
        "focus_distance_m": lens.focus_distance_m.map(number),
        "sensor_mm": lens.sensor_mm.map(|size| size.map(number)),
        "sensor_offset_um": lens.sensor_offset_um.map(|offset| offset.map(number)),
        "horizontal_fov_deg": lens.horizontal_fov_deg.map(number),
        "near": lens.near.map(number),
        "far": lens.far.map(number),
        "world_to_camera": lens.world_to_camera.map(|matrix| matrix.map(number)),
        "world_to_ndc": lens.world_to_ndc.map(|matrix| matrix.map(number)),
    })
}

fn window(window: PixelWindow) -> Value {
    let PixelWindow { x, y, width, height } = window;
    json!({ "x": x, "y": y, "width": width, "height": height })
}

/// A number with the digits it has; what JSON has no word for as a string.
fn number(value: f32) -> Value {
    match value {
        _ if value.is_nan() => json!("nan"),
        f32::INFINITY => json!("inf"),
        f32::NEG_INFINITY => json!("-inf"),
        // The shortest digits of the f32, not those of the f64 that it is widened to
        _ => json!(value.to_string().parse::<f64>().unwrap_or(f64::from(value))),
    }
}
