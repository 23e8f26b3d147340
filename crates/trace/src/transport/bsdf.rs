//! How a surface scatters light: its share, its sampling and its density, together.
//!
//! Vectors are in the frame of the surface, z its shading normal on the side it is seen from, of length 1. A perfectly smooth
//! part has no density: it is told by a density of 0.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{Vec2, Vec3};

use super::albedo::{Albedo, PERFECT};
use super::fresnel;
use super::microfacet::Ggx;

mod rough_glass;

pub(crate) use rough_glass::RoughGlass;

/// Below this roughness a surface is a mirror: its lobe would be narrower than 0.06 degrees.
pub(crate) const SMOOTH: f32 = 0.03;

/// One way that light takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scattered {
    /// Where it comes from.
    pub(crate) direction: Vec3,
    /// Share times cosine over density.
    pub(crate) weight: Vec3,
    /// Density per solid angle; 0 where it comes from one direction only.
    pub(crate) pdf: f32,
    /// How wide the lobe is, for the footprint of what comes next.
    pub(crate) spread: f32,
}

/// What a surface does with light.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Bsdf<'a> {
    /// Lambert.
    Matte(Vec3),
    /// A rough metal, or a rough coat over a diffuse base, mixed by `metallic`.
    Glossy(Glossy<'a>),
    /// A smooth boundary; `eta` is the index beyond it over that on this side.
    Glass { tint: Vec3, eta: f32, thin: bool },
    /// A rough boundary.
    RoughGlass(RoughGlass<'a>),
}

/// Metallic-roughness as of glTF 2.0 (appendix B), made to lose and gain no energy.
///
/// Rough metal gets back what facets reflect to each other (Turquin, "Practical multiple scattering compensation for
/// microfacet models", 2019); the base gets what the coat lets through, in and out (Kelemen and Szirmay-Kalos 2001).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Glossy<'a> {
    pub(crate) color: Vec3,
    pub(crate) metallic: f32,
    pub(crate) roughness: f32,
    pub(crate) ior: f32,
    pub(crate) coat: &'a Albedo,
}

impl Bsdf<'_> {
    /// Whether no density describes any part of it.
    pub(crate) fn is_only_smooth(&self) -> bool {
        match self {
            Self::Matte(_) => false,
            Self::Glossy(glossy) => glossy.is_smooth() && glossy.metallic >= 1.0,
            Self::Glass { .. } => true,
            Self::RoughGlass(_) => false,
        }
    }

    /// The colour of what is scattered whatever the direction.
    pub(crate) fn diffuse(&self, o: Vec3) -> Vec3 {
        match self {
            Self::Matte(color) => *color,
            Self::Glossy(glossy) => glossy.base(o) * (1.0 - glossy.coat.mean(glossy.roughness)),
            Self::Glass { .. } | Self::RoughGlass(_) => Vec3::ZERO,
        }
    }

    /// Share of light from `i` that goes to `o`, times the cosine of `i`; smooth parts aside. Rough glass lets through what comes
    /// from below.
    pub(crate) fn share(&self, o: Vec3, i: Vec3) -> Vec3 {
        if self.is_dark(o, i) {
            return Vec3::ZERO;
        }
        match self {
            Self::Matte(color) => *color * (FRAC_1_PI * i.z),
            Self::Glossy(glossy) => glossy.share(o, i),
            Self::Glass { .. } => Vec3::ZERO,
            Self::RoughGlass(glass) => glass.share(o, i),
        }
    }

    /// Whether nothing can come to `o` from `i`: it looks at the back, or `i` is there and nothing is let through.
    fn is_dark(&self, o: Vec3, i: Vec3) -> bool {
        o.z <= 0.0 || i.z == 0.0 || i.z < 0.0 && !matches!(self, Self::RoughGlass(_))
    }

    /// Density of [`Self::sample`] per solid angle, smooth parts aside.
    pub(crate) fn pdf(&self, o: Vec3, i: Vec3) -> f32 {
        if self.is_dark(o, i) {
            return 0.0;
        }
        match self {
            Self::Matte(_) => FRAC_1_PI * i.z,
            Self::Glossy(glossy) => glossy.pdf(o, i),
            Self::Glass { .. } => 0.0,
            Self::RoughGlass(glass) => glass.pdf(o, i),
        }
    }

    /// Where light may come from that goes to `o`, if any.
    pub(crate) fn sample(&self, o: Vec3, lobe: f32, u: Vec2) -> Option<Scattered> {
        match self {
            Self::Matte(color) => {
                let direction = cosine_weighted(u);
                Some(Scattered { direction, weight: *color, pdf: FRAC_1_PI * direction.z, spread: 1.0 })
            }
            Self::Glossy(glossy) => glossy.sample(o, lobe, u),
            Self::Glass { tint, eta, thin } => Some(glass(*tint, *eta, *thin, o, lobe)),
            Self::RoughGlass(glass) => glass.sample(o, lobe, u),
        }
    }
}

impl Glossy<'_> {
    fn is_smooth(&self) -> bool {
        self.roughness < SMOOTH
    }

    fn ggx(&self) -> Ggx {
        Ggx::new(self.roughness * self.roughness)
    }

    /// What facets reflect at a cosine to them, made up for what they reflect to each other.
    fn facets(&self, o: Vec3, cosine: f32) -> Vec3 {
        let metal = if self.metallic > 0.0 {
            let lost = if self.is_smooth() { 0.0 } else { 1.0 / PERFECT.share(self.roughness, o.z).max(0.05) - 1.0 };
            fresnel::schlick(self.color, cosine) * (Vec3::ONE + self.color * lost)
        } else {
            Vec3::ZERO
        };
        let coat = Vec3::splat(fresnel::dielectric(cosine.clamp(0.0, 1.0), self.ior));
        coat.lerp(metal, self.metallic)
    }

    /// The base as `o` sees it through the coat, over what enters on average.
    fn base(&self, o: Vec3) -> Vec3 {
        let entering = 1.0 - self.coat.mean(self.roughness);
        self.color * ((1.0 - self.metallic) * (1.0 - self.coat.share(self.roughness, o.z)) / entering.max(1e-3))
    }

    /// The chance of taking the facets' lobe.
    fn chance(&self, o: Vec3) -> f32 {
        let facets = self.facets(o, o.z).max_element();
        let coat = self.coat.share(self.roughness, o.z);
        let facets = facets.max(coat * (1.0 - self.metallic));
        let base = self.base(o).max_element();
        if base <= 0.0 { 1.0 } else { (facets / (facets + base)).clamp(0.1, 0.9) }
    }

    fn share(&self, o: Vec3, i: Vec3) -> Vec3 {
        let below = self.base(o) * ((1.0 - self.coat.share(self.roughness, i.z)) * FRAC_1_PI * i.z);
        if self.is_smooth() {
            return below;
        }
        let cosine = o.dot((o + i).normalize_or(Vec3::Z));
        below + self.facets(o, cosine) * self.ggx().reflected(o, i)
    }

    fn pdf(&self, o: Vec3, i: Vec3) -> f32 {
        let chance = self.chance(o);
        let facets = if self.is_smooth() { 0.0 } else { self.ggx().pdf(o, i) };
        chance * facets + (1.0 - chance) * FRAC_1_PI * i.z
    }

    fn sample(&self, o: Vec3, lobe: f32, u: Vec2) -> Option<Scattered> {
        let chance = self.chance(o);
        let takes_facets = lobe < chance;
        if takes_facets && self.is_smooth() {
            let direction = Vec3::new(-o.x, -o.y, o.z);
            return Some(Scattered { direction, weight: self.facets(o, o.z) / chance, pdf: 0.0, spread: 0.0 });
        }
        let direction = if takes_facets { self.ggx().sample(o, u) } else { cosine_weighted(u) };
        if direction.z <= 0.0 {
            return None;
        }
        let pdf = self.pdf(o, direction);
        let spread = if takes_facets { self.roughness * self.roughness } else { 1.0 };
        (pdf > 0.0).then(|| Scattered { direction, weight: self.share(o, direction) / pdf, pdf, spread })
    }
}

/// Reflected or refracted by chance, as Fresnel says. Radiance grows with the square of the index it enters.
fn glass(tint: Vec3, eta: f32, thin: bool, o: Vec3, lobe: f32) -> Scattered {
    let share = if thin { fresnel::sheet } else { fresnel::dielectric };
    let reflected = share(o.z.min(1.0), eta);
    if lobe < reflected {
        let direction = Vec3::new(-o.x, -o.y, o.z);
        return Scattered { direction, weight: Vec3::ONE, pdf: 0.0, spread: 0.0 };
    }
    if thin {
        return Scattered { direction: -o, weight: tint, pdf: 0.0, spread: 0.0 };
    }
    let (x, y) = (-o.x / eta, -o.y / eta);
    let direction = Vec3::new(x, y, -(1.0 - x * x - y * y).max(0.0).sqrt());
    Scattered { direction, weight: tint / (eta * eta), pdf: 0.0, spread: 0.0 }
}

/// A direction with density cos / pi.
fn cosine_weighted(u: Vec2) -> Vec3 {
    let (r, phi) = (u.x.sqrt(), TAU * u.y);
    Vec3::new(r * phi.cos(), r * phi.sin(), (1.0 - u.x).max(1e-12).sqrt())
}

#[cfg(test)]
mod laws;
