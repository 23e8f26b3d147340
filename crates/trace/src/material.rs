//! What a surface reflects and emits.

use glam::{DVec3, Vec3};

/// The diffuse colour of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pigment {
    /// The same everywhere.
    Constant(Vec3),
    /// Square tiles in two colours, fixed in world space.
    Checker {
        /// Colours of the tiles: the first where floor(a) + floor(b) is even.
        colors: [Vec3; 2],
        /// Edge of a tile in scene units.
        side: f64,
        /// The world axes a and b (0 = x, 1 = y, 2 = z).
        axes: [usize; 2],
    },
}

impl Pigment {
    /// The colour at a point of the world.
    #[inline]
    #[must_use]
    pub fn at(&self, p_world: DVec3) -> Vec3 {
        match *self {
            Self::Constant(color) => color,
            Self::Checker { colors, side, axes: [a, b] } => {
                let tile = (p_world[a] / side).floor() + (p_world[b] / side).floor();
                colors[usize::from(tile.rem_euclid(2.0) >= 1.0)]
            }
        }
    }

    /// The largest value it takes.
    fn brightest(&self) -> f32 {
        match *self {
            Self::Constant(color) => color.max_element(),
            Self::Checker { colors, .. } => colors[0].max(colors[1]).max_element(),
        }
    }
}

/// A Lambertian surface that may also glow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Diffuse colour Kd.
    pub pigment: Pigment,
    /// Radiance it emits on both sides.
    pub emission: Vec3,
}

impl Material {
    /// A surface of one colour.
    #[must_use]
    pub fn matte(color: Vec3) -> Self {
        Self { pigment: Pigment::Constant(color), emission: Vec3::ZERO }
    }

    /// A black surface that glows.
    #[must_use]
    pub fn glowing(emission: Vec3) -> Self {
        Self { pigment: Pigment::Constant(Vec3::ZERO), emission }
    }

    /// A bound on what it sends out under `light`.
    pub(crate) fn brightest(&self, light: f32) -> f32 {
        self.pigment.brightest() * light + self.emission.max_element()
    }
}
