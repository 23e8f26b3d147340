//! Glass whose surface is rough.
//!
//! Walter, Marschner, Li, Torrance, "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007), with facets chosen
//! among those that are seen (Heitz 2018), and reflected or refracted by chance as Fresnel says. A sheet without thickness
//! sends on what it lets through as it reflects, mirrored in its plane. What facets send to each other is lost in that model, at
//! full roughness a tenth straight on and half aslant; all is made brighter by what is lost on average for the direction it is seen from (Turquin 2019), so that
//! a furnace stays 1, at the price of reciprocity between directions that lose differently.

use glam::{Vec2, Vec3};

use super::Scattered;
use crate::transport::albedo::Albedo;
use crate::transport::fresnel;
use crate::transport::microfacet::Ggx;

/// A rough boundary.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RoughGlass<'a> {
    pub(crate) tint: Vec3,
    /// The index beyond it over that on this side.
    pub(crate) eta: f32,
    pub(crate) thin: bool,
    pub(crate) roughness: f32,
    /// What is left of light that facets send on once.
    pub(crate) kept: &'a Albedo,
}

/// A facet between two directions.
struct Facet {
    normal: Vec3,
    /// Cosines of both directions to it, both positive.
    cosines: [f32; 2],
    /// Share that it reflects.
    reflected: f32,
}

impl RoughGlass<'_> {
    /// Table of what facets of a boundary keep, reflected and refracted together.
    pub(crate) fn kept(eta: f32) -> Albedo {
        Albedo::from_shares(|ggx, o, u| {
            // Look closer at the few facets that stand steeply: near the normal only they lose anything
            let rest = 1.0 - u.x;
            let density = 2.0 * rest;
            let u = Vec2::new(1.0 - rest * rest, u.y);
            let facet = ggx.facet(o, u);
            let cosine = o.dot(facet).clamp(0.0, 1.0);
            let reflected = fresnel::dielectric(cosine, eta);
            let up = reflect(o, facet);
            let above = if up.z > 0.0 { ggx.weight(o, up) } else { 0.0 };
            let down = refract(o, facet, eta).filter(|down| down.z < 0.0);
            density * (reflected * above + (1.0 - reflected) * down.map_or(0.0, |down| ggx.seen(down)))
        })
    }

    fn ggx(&self) -> Ggx {
        Ggx::new(self.roughness * self.roughness)
    }

    /// Made up for what facets send to each other.
    fn gain(&self, o: Vec3) -> f32 {
        1.0 / self.kept.share(self.roughness, o.z).max(0.05)
    }

    fn reflected(&self, cosine: f32) -> f32 {
        let share = if self.thin { fresnel::sheet } else { fresnel::dielectric };
        share(cosine.clamp(0.0, 1.0), self.eta)
    }

    /// The facet that sends light from `i` to `o`, if one does.
    fn facet(&self, o: Vec3, i: Vec3) -> Option<Facet> {
        let sum = if i.z > 0.0 {
            o + i
        } else if self.thin {
            o + mirrored(i)
        } else {
            o + self.eta * i
        };
        let normal = sum.try_normalize()?;
        let normal = if normal.z < 0.0 { -normal } else { normal };
        let is_through = i.z < 0.0 && !self.thin;
        let other = if self.thin && i.z < 0.0 { mirrored(i) } else { i };
        let cosines = [o.dot(normal), if is_through { -other.dot(normal) } else { other.dot(normal) }];
        let reflected = self.reflected(cosines[0]);
        (cosines[0] > 0.0 && cosines[1] > 0.0).then_some(Facet { normal, cosines, reflected })
    }

    /// Share of light from `i`, on either side, that goes to `o`, times the cosine of `i`.
    pub(super) fn share(&self, o: Vec3, i: Vec3) -> Vec3 {
        let Some(facet) = self.facet(o, i) else { return Vec3::ZERO };
        let ggx = self.ggx();
        let gain = self.gain(o);
        if i.z > 0.0 {
            return Vec3::splat(gain * facet.reflected * ggx.reflected(o, i));
        }
        let through = (1.0 - facet.reflected) * gain;
        if self.thin {
            return self.tint * (through * ggx.reflected(o, mirrored(i)));
        }
        // |i.h| |o.h| (1 - F) G D / (|o.n| (o.h + eta i.h)^2)
        let [of_o, of_i] = facet.cosines;
        let bend = of_o - self.eta * of_i;
        let g = ggx.seen(o) * ggx.seen(i);
        self.tint * (through * of_o * of_i * g * ggx.density(facet.normal) / (o.z * bend * bend))
    }

    /// Density of [`Self::sample`] per solid angle.
    pub(super) fn pdf(&self, o: Vec3, i: Vec3) -> f32 {
        let Some(facet) = self.facet(o, i) else { return 0.0 };
        let ggx = self.ggx();
        if i.z > 0.0 {
            return facet.reflected * ggx.pdf(o, i);
        }
        let through = 1.0 - facet.reflected;
        if self.thin {
            return through * ggx.pdf(o, mirrored(i));
        }
        let [of_o, of_i] = facet.cosines;
        let bend = of_o - self.eta * of_i;
        through * ggx.seen(o) * ggx.density(facet.normal) * of_o / o.z * (self.eta * self.eta * of_i / (bend * bend))
    }

    /// Where light may come from that goes to `o`, if any.
    pub(super) fn sample(&self, o: Vec3, lobe: f32, u: Vec2) -> Option<Scattered> {
        let ggx = self.ggx();
        let facet = ggx.facet(o, u);
        let reflected = self.reflected(o.dot(facet));
        let gain = self.gain(o);
        let up = reflect(o, facet);
        let (direction, weight) = if lobe < reflected {
            (up, Vec3::splat(gain * ggx.weight(o, up)))
        } else if self.thin {
            (mirrored(up), self.tint * (gain * ggx.weight(o, up)))
        } else {
            let down = refract(o, facet, self.eta)?;
            (down, self.tint * (gain * ggx.seen(down) / (self.eta * self.eta)))
        };
        // What would go on to other facets is lost here
        let is_lost = if lobe < reflected || self.thin { up.z <= 0.0 } else { direction.z >= 0.0 };
        let pdf = if is_lost { 0.0 } else { self.pdf(o, direction) };
        let spread = self.roughness * self.roughness;
        (pdf > 0.0).then_some(Scattered { direction, weight, pdf, spread })
    }
}

/// The same on the other side of the surface.
fn mirrored(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

fn reflect(o: Vec3, facet: Vec3) -> Vec3 {
    (2.0 * o.dot(facet) * facet - o).normalize()
}

/// Snell at a facet; `None` where all is reflected.
fn refract(o: Vec3, facet: Vec3, eta: f32) -> Option<Vec3> {
    let cosine = o.dot(facet);
    let sine2 = (1.0 - cosine * cosine).max(0.0) / (eta * eta);
    let through = (1.0 - sine2).max(0.0).sqrt();
    (sine2 < 1.0).then(|| ((cosine / eta - through) * facet - o / eta).normalize())
}

#[cfg(test)]
mod laws;
