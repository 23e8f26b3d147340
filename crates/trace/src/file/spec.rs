//! A scene file as it is written; nothing here is checked beyond its form.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

pub(crate) use super::shutter::ShutterSpec;
use super::triple::Triple;

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FileSpec {
    pub(crate) format: u32,
    #[serde(default)]
    pub(crate) description: String,
    pub(crate) metres_per_unit: Option<f64>,
    pub(crate) sky: Option<Triple>,
    #[serde(default)]
    pub(crate) shadow_bias: f64,
    #[serde(default)]
    pub(crate) materials: BTreeMap<String, MaterialSpec>,
    #[serde(default)]
    pub(crate) shapes: BTreeMap<String, ShapeSpec>,
    #[serde(default)]
    pub(crate) meshes: BTreeMap<String, MeshSpec>,
    #[serde(default)]
    pub(crate) lights: BTreeMap<String, LightSpec>,
    pub(crate) environment: Option<EnvironmentSpec>,
    #[serde(default)]
    pub(crate) render: RenderSpec,
    #[serde(default)]
    pub(crate) groups: BTreeMap<String, Vec<PartSpec>>,
    #[serde(default)]
    pub(crate) objects: Vec<ObjectSpec>,
    #[serde(default)]
    pub(crate) camera: CameraSpec,
    #[serde(default)]
    pub(crate) lens: LensSpec,
    #[serde(default)]
    pub(crate) film: FilmSpec,
    #[serde(default)]
    pub(crate) shots: BTreeMap<String, ShotSpec>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MaterialSpec {
    pub(crate) color: Option<Triple>,
    pub(crate) checker: Option<CheckerSpec>,
    pub(crate) emission: Option<Triple>,
    #[serde(default)]
    pub(crate) area_light: bool,
    pub(crate) metallic: Option<f32>,
    pub(crate) roughness: Option<f32>,
    pub(crate) ior: Option<f32>,
    pub(crate) glass: Option<GlassSpec>,
    pub(crate) opacity: Option<f32>,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct GlassSpec {
    pub(crate) ior: Option<f32>,
    #[serde(default)]
    pub(crate) thin: bool,
    #[serde(default)]
    pub(crate) roughness: f32,
    pub(crate) attenuation_color: Option<Triple>,
    pub(crate) attenuation_distance: Option<f32>,
}

/// Light from all directions, out of a picture.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EnvironmentSpec {
    pub(crate) file: PathBuf,
    pub(crate) strength: Option<Triple>,
    #[serde(default)]
    pub(crate) rotate_deg: f64,
}

/// How far light is followed.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RenderSpec {
    pub(crate) bounces: Option<u32>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CheckerSpec {
    pub(crate) colors: [Triple; 2],
    pub(crate) side: f64,
    #[serde(default)]
    pub(crate) axes: AxesSpec,
}

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum AxesSpec {
    #[default]
    Xz,
    Xy,
    Yz,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum ShapeSpec {
    Plane { size: Option<[f64; 2]> },
    Box { size: Triple },
    Sphere { radius: f64 },
    Cylinder { radius: f64, height: f64 },
    Cone { radius: f64, height: f64 },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MeshSpec {
    pub(crate) file: Option<PathBuf>,
    pub(crate) vertices: Option<Vec<[f64; 3]>>,
    pub(crate) triangles: Option<Vec<[u32; 3]>>,
    pub(crate) smooth: Option<bool>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum LightSpec {
    Ambient { strength: Triple },
    Sun { toward: [f64; 3], strength: Triple, size_deg: Option<f64> },
    Point { at: [f64; 3], strength: Triple },
    Spot { at: [f64; 3], look_at: [f64; 3], strength: Triple, inner_deg: f64, outer_deg: f64 },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectSpec {
    pub(crate) shape: Option<Spanned<String>>,
    pub(crate) mesh: Option<Spanned<String>>,
    pub(crate) group: Option<Spanned<String>>,
    pub(crate) material: Option<Spanned<String>>,
    pub(crate) placements: Option<Vec<Spanned<PlacementSpec>>>,
    pub(crate) scatter: Option<Spanned<ScatterSpec>>,
    pub(crate) moves: Option<Spanned<Vec<MoveSpec>>>,
    pub(crate) ease: Option<EaseSpec>,
}

/// Where something is in a frame.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MoveSpec {
    pub(crate) frame: f64,
    pub(crate) translate: Option<[f64; 3]>,
    pub(crate) rotate_deg: Option<[f64; 3]>,
    pub(crate) scale: Option<Triple>,
}

/// A part of a group, placed in it.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PartSpec {
    pub(crate) shape: Option<Spanned<String>>,
    pub(crate) mesh: Option<Spanned<String>>,
    pub(crate) material: Option<Spanned<String>>,
    #[serde(default)]
    pub(crate) place: PlacementSpec,
}

/// Copies at places that a seed makes.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ScatterSpec {
    pub(crate) count: u32,
    #[serde(default)]
    pub(crate) seed: u64,
    pub(crate) from: [f64; 3],
    pub(crate) to: [f64; 3],
    pub(crate) turn_deg: Option<[f64; 3]>,
    pub(crate) scale: Option<[f64; 2]>,
    #[serde(default)]
    pub(crate) spacing: f64,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PlacementSpec {
    pub(crate) translate: Option<[f64; 3]>,
    pub(crate) rotate_deg: Option<[f64; 3]>,
    pub(crate) scale: Option<Triple>,
    pub(crate) moves: Option<Spanned<Vec<MoveSpec>>>,
    pub(crate) ease: Option<EaseSpec>,
}

/// A sparse override of the file's camera, lens and film, or of another shot's.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ShotSpec {
    #[serde(default)]
    pub(crate) description: String,
    pub(crate) from: Option<Spanned<String>>,
    #[serde(default)]
    pub(crate) camera: CameraSpec,
    #[serde(default)]
    pub(crate) lens: LensSpec,
    #[serde(default)]
    pub(crate) film: FilmSpec,
    #[serde(default)]
    pub(crate) keys: Vec<KeySpec>,
    pub(crate) ease: Option<EaseSpec>,
}

/// What a shot sets in one frame; the tables are read once they are known for a frame.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct KeySpec {
    pub(crate) frame: i64,
    #[serde(default)]
    pub(crate) camera: toml::Table,
    #[serde(default)]
    pub(crate) lens: toml::Table,
    #[serde(default)]
    pub(crate) film: toml::Table,
}

#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum EaseSpec {
    #[default]
    Linear,
    Smooth,
}

/// Declares a table all of whose keys may be missing, and may be laid over another of its kind.
macro_rules! sparse_table {
    ($(#[$doc:meta])* $name:ident { $($key:ident: $value:ty),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Default, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub(crate) struct $name {
            $(pub(crate) $key: Option<$value>),+
        }

        impl $name {
            /// Every key of `self` that is set, else that of `base`.
            pub(crate) fn over(&self, base: &Self) -> Self {
                Self { $($key: self.$key.clone().or_else(|| base.$key.clone())),+ }
            }
        }
    };
}

sparse_table!(
    /// Where the camera stands and looks.
    CameraSpec {
        position: [f64; 3],
        look_at: [f64; 3],
        up: [f64; 3],
        right: [f64; 3],
        forward: [f64; 3],
        frame: f64,
        shutter: ShutterSpec,
    }
);

sparse_table!(
    /// The lens.
    LensSpec {
        focal_length_mm: f64,
        focal_length: f64,
        image_distance_mm: f64,
        image_distance: f64,
        tilt_deg: f64,
        swing_deg: f64,
        shift: ShiftSpec,
        focus: FocusSpec,
        aperture: ApertureSpec,
        iris: IrisSpec,
        blades: BladesSpec,
        anamorphic: f64,
        cat_eye: f64,
    }
);

sparse_table!(
    /// What the picture shows, in how many pixels.
    FilmSpec {
        size: [u32; 2],
        window: WindowSpec,
    }
);

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum ShiftSpec {
    Mm([f64; 2]),
    Q([f64; 2]),
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum FocusSpec {
    Infinity,
    Distance(f64),
    Plane { point: [f64; 3], normal: [f64; 3] },
    Nakane { theta_deg: f64, distance: f64 },
    W([f64; 3]),
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum ApertureSpec {
    Pinhole,
    FNumber(f64),
    Radius(f64),
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum IrisSpec {
    Tilted,
    Upright,
    Normal([f64; 3]),
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BladesSpec {
    pub(crate) count: u32,
    #[serde(default)]
    pub(crate) rotation_deg: f64,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "snake_case")]
pub(crate) enum WindowSpec {
    FovDeg(f64),
    SensorMm([f64; 2]),
    Sensor([f64; 2]),
    Q([f64; 4]),
}
