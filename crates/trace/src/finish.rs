//! What a surface is made of, where a diffuse colour does not say it all.

use crate::{Absorption, TextureMap};

/// How light is reflected.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Matter {
    /// As the diffuse colour says, whatever the direction (Lambert).
    #[default]
    Matte,
    /// Metallic-roughness as of glTF 2.0: a rough metal of the surface's colour, or a rough dielectric coat over a
    /// diffuse base of that colour, or a share of each.
    Glossy {
        /// Share of metal, 0 to 1.
        metallic: f32,
        /// Perceived roughness, 0 (a mirror) to 1; its square is the alpha of GGX.
        roughness: f32,
        /// Refractive index of the coat, 1 to 4.
        ior: f32,
    },
    /// Clear glass, whose colour tints what goes through its surface.
    Glass {
        /// Refractive index, 1 to 4.
        ior: f32,
        /// A sheet without thickness: light goes straight through it.
        thin: bool,
        /// Perceived roughness of its surface, 0 (polished) to 1; its square is the alpha of GGX.
        roughness: f32,
        /// What it takes away inside, if it is not a sheet.
        absorption: Option<Absorption>,
    },
}

/// Where a surface has holes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Alpha {
    /// Nowhere.
    #[default]
    Opaque,
    /// Where alpha is below this.
    Mask(f32),
    /// It covers the share alpha of what lies behind it. In depth it counts where that is half or more.
    Blend,
}

/// What a surface is made of, and the textures that say it place by place; everything beyond a `Material`'s colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Finish {
    /// What people call it.
    pub name: String,
    /// How it reflects.
    pub matter: Matter,
    /// Multiplies the colour (and alpha).
    pub color_map: Option<TextureMap>,
    /// Multiplies the emission.
    pub emission_map: Option<TextureMap>,
    /// Multiplies the roughness (green) and the share of metal (blue).
    pub surface_map: Option<TextureMap>,
    /// Normals in tangent space, and how strongly they count.
    pub normal_map: Option<(TextureMap, f32)>,
    /// Where it has holes.
    pub alpha: Alpha,
    /// Multiplies alpha.
    pub opacity: f32,
    /// Whether what it emits lights other surfaces.
    pub is_light: bool,
    /// Whether its back is a surface like its front: a leaf, a curtain. Hidden layers hold such backs too. (Light makes no
    /// difference between the two of any surface.)
    pub is_double_sided: bool,
}

impl Matter {
    /// Polished glass that absorbs nothing.
    #[must_use]
    pub fn glass(ior: f32, thin: bool) -> Self {
        Self::Glass { ior, thin, roughness: 0.0, absorption: None }
    }
}

impl Default for Finish {
    fn default() -> Self {
        Self {
            name: String::new(),
            matter: Matter::Matte,
            color_map: None,
            emission_map: None,
            surface_map: None,
            normal_map: None,
            alpha: Alpha::Opaque,
            opacity: 1.0,
            is_light: false,
            is_double_sided: false,
        }
    }
}

impl Finish {
    /// Whether it says no more than a `Material` does.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        self.matter == Matter::Matte
            && self.color_map.is_none()
            && self.emission_map.is_none()
            && self.normal_map.is_none()
            && self.alpha == Alpha::Opaque
            && !self.is_light
    }

    /// Its texture maps.
    pub(crate) fn maps(&self) -> impl Iterator<Item = &TextureMap> {
        let maps = [&self.color_map, &self.emission_map, &self.surface_map];
        maps.into_iter().flatten().chain(self.normal_map.iter().map(|(map, _)| map))
    }

    /// Adds it to a checksum.
    pub(crate) fn add_to(&self, fingerprint: &mut crc32fast::Hasher) {
        self.maps().for_each(|map| map.add_to(fingerprint));
        let present = [&self.color_map, &self.emission_map, &self.surface_map].map(Option::is_some);
        let scale = self.normal_map.as_ref().map(|(_, scale)| scale);
        let rest = (self.matter, present, scale, self.alpha, self.opacity, self.is_light);
        fingerprint.update(format!("{rest:?}").as_bytes());
    }
}
