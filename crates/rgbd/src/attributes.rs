//! The header's attributes: the standard ones, and ours under `tiltshift.`.

use std::path::Path;

use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use exr::meta::header::{Header, LayerAttributes};
use glam::{DMat4, DVec4};
use optics::Camera;

use crate::camera_text::{camera_from_text, text_from_camera};
use crate::encode_exr::{FileKind, Labels, name_fault, text};
use crate::{Head, LensAttributes, Notes, PixelWindow, Primaries, ReadError, WriteError};

const KIND: &str = "tiltshift.kind";
const LAYERS: &str = "tiltshift.layers";
const SAMPLES: &str = "tiltshift.samples";
const CAMERA: &str = "tiltshift.camera";
const METRES_PER_UNIT: &str = "tiltshift.metresPerUnit";
const NOTE: &str = "tiltshift.note.";
const FOCAL_LENGTH: &str = "effectiveFocalLength";
const IMAGE_DISTANCE: &str = "pinholeFocalLength";
const SENSOR: &str = "sensorOverallDimensions";
const SENSOR_OFFSET: &str = "sensorCenterOffset";

/// All that a file of ours says in its header, windows and channels aside.
pub(crate) fn own_attributes(path: &Path, head: &Head, labels: &Labels<'_>) -> Result<LayerAttributes, WriteError> {
    let lens = &labels.options.lens;
    let mut attributes = LayerAttributes {
        aperture: lens.f_number,
        focus: lens.focus_distance_m,
        horizontal_field_of_view: lens.horizontal_fov_deg,
        near_clip_plane: lens.near,
        far_clip_plane: lens.far,
        world_to_camera: lens.world_to_camera,
        world_to_normalized_device: lens.world_to_ndc,
        software_name: Some(text(concat!("tiltshift ", env!("CARGO_PKG_VERSION")))),
        ..LayerAttributes::default()
    };
    let mut other = Vec::new();

    // Name what the file holds
    match labels.kind {
        FileKind::Frame { layers } => {
            other.push((KIND.to_owned(), AttributeValue::Text(text("frame"))));
            other.push((LAYERS.to_owned(), AttributeValue::I32(i32::try_from(layers).unwrap_or(i32::MAX))));
        }
        FileKind::Picture => other.push((KIND.to_owned(), AttributeValue::Text(text("picture")))),
        FileKind::Truth { samples: [a, b] } => {
            other.push((KIND.to_owned(), AttributeValue::Text(text("truth"))));
            other.push((SAMPLES.to_owned(), AttributeValue::Text(text(&format!("{a} {b}")))));
        }
    }

    // Camera and unit, bit for bit, and what other programs understand of them
    if let Some(camera) = &head.camera {
        let exact = text_from_camera(camera).ok_or_else(|| WriteError::BadNumber {
            path: path.into(),
            what: "a number of the camera",
            value: f64::NAN,
            wanted: "finite and within its range",
        })?;
        other.push((CAMERA.to_owned(), AttributeValue::Text(text(&exact))));
        attributes.world_to_camera = Some(camera.pose.camera_from_world().as_mat4().to_cols_array());
        attributes.world_to_normalized_device = Some(ndc_from_world(camera).as_mat4().to_cols_array());
    }
    if let Some(metres) = head.metres_per_unit {
        other.push((METRES_PER_UNIT.to_owned(), AttributeValue::F64(metres)));
    }

    // The lens as others name it
    let numbers = [(FOCAL_LENGTH, lens.focal_length_mm), (IMAGE_DISTANCE, lens.image_distance_mm)];
    other.extend(numbers.into_iter().filter_map(|(name, x)| Some((name.to_owned(), AttributeValue::F32(x?)))));
    let pairs = [(SENSOR, lens.sensor_mm), (SENSOR_OFFSET, lens.sensor_offset_um)];
    other.extend(pairs.into_iter().filter_map(|(name, pair)| {
        let [x, y] = pair?;
        Some((name.to_owned(), AttributeValue::FloatVec2(Vec2(x, y))))
    }));

    // Free text
    for (name, note) in &labels.options.notes {
        if let Some(why) = name_fault(name, 200) {
            return Err(WriteError::BadName { path: path.into(), what: "note", name: name.clone(), why });
        }
        other.push((format!("{NOTE}{name}"), AttributeValue::Text(text(note))));
    }
    attributes.other = other.into_iter().map(|(name, value)| (text(&name), value)).collect();
    Ok(attributes)
}

/// From world space to (x, y, 1, 1) * depth with (0, 0) the top left and (1, 1) the bottom right corner of the film.
fn ndc_from_world(camera: &Camera) -> DMat4 {
    let (min, max) = (camera.film.min(), camera.film.max());
    let size = max - min;
    // x = (q.x - min.x) / width, y = (max.y - q.y) / height, z = 1 / depth, all times depth
    let rows = [
        DVec4::new(1.0 / size.x, 0.0, -min.x / size.x, 0.0),
        DVec4::new(0.0, -1.0 / size.y, max.y / size.y, 0.0),
        DVec4::W,
        DVec4::Z,
    ];
    DMat4::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose() * camera.pose.camera_from_world()
}

/// What a file of ours says that it holds; `None` for a foreign one.
pub(crate) fn file_kind(path: &Path, meta: &MetaData) -> Result<Option<FileKind>, ReadError> {
    let header = &meta.headers[0];
    let Some(kind) = text_attribute(header, KIND) else { return Ok(None) };
    let bad = |name: &str, reason: &str| ReadError::BadAttribute {
        path: path.into(),
        name: name.into(),
        reason: reason.into(),
    };
    match kind.as_str() {
        "frame" => match other(header, LAYERS) {
            Some(AttributeValue::I32(layers @ 1..=1000)) => Ok(Some(FileKind::Frame { layers: *layers as usize })),
            _ => Err(bad(LAYERS, "it must be a number from 1 to 1000")),
        },
        "picture" => Ok(Some(FileKind::Picture)),
        "truth" => {
            let counts = text_attribute(header, SAMPLES).unwrap_or_default();
            let counts: Option<Vec<u32>> = counts.split(' ').map(|count| count.parse().ok()).collect();
            let samples = counts.and_then(|counts| counts.try_into().ok());
            let samples = samples.ok_or_else(|| bad(SAMPLES, "it must be two whole numbers"))?;
            Ok(Some(FileKind::Truth { samples }))
        }
        _ => Err(bad(KIND, "it must be frame, picture or truth")),
    }
}

/// Windows, colours, unit and camera of a file.
pub(crate) fn head(path: &Path, meta: &MetaData) -> Result<Head, ReadError> {
    let header = &meta.headers[0];
    let shared = &header.shared_attributes;
    let pair = |v: Vec2<f32>| [v.x(), v.y()];
    let primaries = shared.chromaticities.map_or(Primaries::REC709, |c| Primaries {
        red: pair(c.red),
        green: pair(c.green),
        blue: pair(c.blue),
        white: pair(c.white),
    });
    let bad = |name: &str, reason| ReadError::BadAttribute { path: path.into(), name: name.into(), reason };
    let camera = match text_attribute(header, CAMERA) {
        Some(text) => Some(camera_from_text(&text).map_err(|reason| bad(CAMERA, reason))?),
        None => None,
    };
    let metres_per_unit = match other(header, METRES_PER_UNIT) {
        Some(AttributeValue::F64(metres)) => Some(*metres),
        _ => None,
    };
    // A pixel aspect that is none is a habit of some writers, not a reason to refuse
    let aspect = shared.pixel_aspect;
    let pixel_aspect = if aspect.is_finite() && aspect > 0.0 { aspect } else { 1.0 };
    Ok(Head { display: window(&shared.display_window), pixel_aspect, primaries, metres_per_unit, camera })
}

/// What the header says of lens and sensor in standard attributes.
pub(crate) fn lens_attributes(header: &Header) -> LensAttributes {
    let own = &header.own_attributes;
    let number = |name| match other(header, name)? {
        AttributeValue::F32(x) => Some(*x),
        AttributeValue::F64(x) => Some(*x as f32),
        _ => None,
    };
    let pair = |name| match other(header, name)? {
        AttributeValue::FloatVec2(v) => Some([v.x(), v.y()]),
        _ => None,
    };
    LensAttributes {
        focal_length_mm: number(FOCAL_LENGTH),
        image_distance_mm: number(IMAGE_DISTANCE),
        f_number: own.aperture,
        focus_distance_m: own.focus,
        sensor_mm: pair(SENSOR),
        sensor_offset_um: pair(SENSOR_OFFSET),
        horizontal_fov_deg: own.horizontal_field_of_view,
        near: own.near_clip_plane,
        far: own.far_clip_plane,
        world_to_camera: own.world_to_camera,
        world_to_ndc: own.world_to_normalized_device,
    }
}

/// The free text that a file of ours carries.
pub(crate) fn notes(header: &Header) -> Notes {
    let texts = header.own_attributes.other.iter();
    let notes = texts.filter_map(|(name, value)| match value {
        AttributeValue::Text(note) => Some((string(name).strip_prefix(NOTE)?.to_owned(), string(note))),
        _ => None,
    });
    notes.collect()
}

/// The window of OpenEXR bounds.
pub(crate) fn window(bounds: &exr::meta::attribute::IntegerBounds) -> PixelWindow {
    let size = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    PixelWindow {
        x: bounds.position.x(),
        y: bounds.position.y(),
        width: size(bounds.size.width()),
        height: size(bounds.size.height()),
    }
}

/// A text as UTF-8; bytes that are none become replacement characters.
pub(crate) fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}

fn other<'a>(header: &'a Header, name: &str) -> Option<&'a AttributeValue> {
    header.own_attributes.other.get(&text(name))
}

fn text_attribute(header: &Header, name: &str) -> Option<String> {
    match other(header, name)? {
        AttributeValue::Text(value) => Some(string(value)),
        _ => None,
    }
}
