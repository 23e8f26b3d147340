//! How a texture lies on a mesh.

use std::sync::Arc;

use glam::{Mat2, Vec2, Vec4};

use super::Texture;

/// What lies beyond the rim of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// The texture, every second time turned round.
    Mirror,
    /// Its rim.
    Clamp,
}

impl Wrap {
    /// A coordinate brought near [0, 1]; what is no number is 0.
    pub(super) fn into_unit(self, t: f32) -> f32 {
        if !t.is_finite() {
            return 0.0;
        }
        match self {
            Self::Repeat => t - t.floor(),
            Self::Mirror => 1.0 - (1.0 - (t - 2.0 * (0.5 * t).floor())).abs(),
            Self::Clamp => t.clamp(0.0, 1.0),
        }
    }

    /// The texel at an index that may lie one beyond the rim.
    pub(super) fn index(self, i: i64, size: usize) -> usize {
        match self {
            Self::Repeat => i.rem_euclid(size as i64) as usize,
            Self::Mirror | Self::Clamp => i.clamp(0, size as i64 - 1) as usize,
        }
    }
}

/// A texture, the coordinates of the mesh that it goes by, and what is done to them first.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureMap {
    /// The picture.
    pub texture: Arc<Texture>,
    /// Beyond the rim, along u and v.
    pub wrap: [Wrap; 2],
    /// Which of the mesh's two sets of coordinates.
    pub set: usize,
    /// Coordinates are multiplied by this,
    pub scale: Mat2,
    /// and this is added.
    pub offset: Vec2,
}

impl TextureMap {
    /// A texture that repeats, by the first set of coordinates as they are.
    #[must_use]
    pub fn new(texture: Arc<Texture>) -> Self {
        Self { texture, wrap: [Wrap::Repeat; 2], set: 0, scale: Mat2::IDENTITY, offset: Vec2::ZERO }
    }

    /// The value where the mesh has these coordinates; `width` is how much of them the ray covers.
    pub(crate) fn at(&self, uv: Vec2, width: f32) -> Vec4 {
        let [columns, rows] = self.texture.size().map(|size| size as f32);
        let texels = width * (self.scale.determinant().abs() * columns * rows).sqrt();
        self.texture.sample(self.scale * uv + self.offset, self.wrap, texels)
    }

    /// Adds it to a checksum.
    pub(crate) fn add_to(&self, fingerprint: &mut crc32fast::Hasher) {
        self.texture.add_to(fingerprint);
        fingerprint.update(format!("{:?}", (self.wrap, self.set, self.scale, self.offset)).as_bytes());
    }
}
