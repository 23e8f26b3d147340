//! The GGX distribution of microfacets, seen ones sampled.
//!
//! Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007); Heitz, "Understanding the
//! Masking-Shadowing Function" (JCGT 2014) and "Sampling the GGX Distribution of Visible Normals" (JCGT 2018). Vectors are
//! in the frame of the surface, its normal z, and of length 1.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

/// Isotropic GGX of a width alpha.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ggx {
    alpha: f32,
}

impl Ggx {
    pub(crate) fn new(alpha: f32) -> Self {
        Self { alpha }
    }

    /// Density of facets with a normal, per projected area.
    pub(crate) fn density(self, h: Vec3) -> f32 {
        // alpha^2 cos^2 + sin^2, without cancellation
        let a2 = self.alpha * self.alpha;
        let t = a2 * h.z * h.z + h.x * h.x + h.y * h.y;
        a2 / (PI * t * t)
    }

    /// Smith's Lambda.
    fn lambda(self, w: Vec3) -> f32 {
        let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
        0.5 * ((1.0 + self.alpha * self.alpha * tan2).sqrt() - 1.0)
    }

    /// Smith's G1: the share of facets that a direction sees of those that it would see without masking.
    pub(crate) fn seen(self, w: Vec3) -> f32 {
        1.0 / (1.0 + self.lambda(w))
    }

    /// D G2 / (4 cos o): what is reflected from `o` to `i` times cos i, but for Fresnel; both above the surface.
    pub(crate) fn reflected(self, o: Vec3, i: Vec3) -> f32 {
        let h = (o + i).normalize_or_zero();
        self.density(h) / (4.0 * o.z * (1.0 + self.lambda(o) + self.lambda(i)))
    }

    /// Density of [`Self::sample`] at `i`, per solid angle: G1 D / (4 cos o).
    pub(crate) fn pdf(self, o: Vec3, i: Vec3) -> f32 {
        let h = (o + i).normalize_or_zero();
        self.density(h) / (4.0 * o.z * (1.0 + self.lambda(o)))
    }

    /// What a sample counts, but for Fresnel: G2 / G1.
    pub(crate) fn weight(self, o: Vec3, i: Vec3) -> f32 {
        let seen = 1.0 + self.lambda(o);
        seen / (seen + self.lambda(i))
    }

    /// A direction reflected by one of the facets that `o` sees; it may go below the surface.
    pub(crate) fn sample(self, o: Vec3, u: Vec2) -> Vec3 {
        let h = self.facet(o, u);
        (2.0 * o.dot(h) * h - o).normalize()
    }

    /// The normal of one of the facets that `o` sees.
    pub(crate) fn facet(self, o: Vec3, u: Vec2) -> Vec3 {
        // Stretch to the hemisphere
        let stretched = Vec3::new(self.alpha * o.x, self.alpha * o.y, o.z).normalize();
        let across = stretched.x * stretched.x + stretched.y * stretched.y;
        let t1 = if across > 0.0 { Vec3::new(-stretched.y, stretched.x, 0.0) / across.sqrt() } else { Vec3::X };
        let t2 = stretched.cross(t1);
        // Choose a point of the projected hemisphere
        let (r, phi) = (u.x.sqrt(), TAU * u.y);
        let p1 = r * phi.cos();
        let s = 0.5 * (1.0 + stretched.z);
        let p2 = (1.0 - s) * (1.0 - p1 * p1).max(0.0).sqrt() + s * r * phi.sin();
        let n = p1 * t1 + p2 * t2 + (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt() * stretched;
        // Squeeze it back
        Vec3::new(self.alpha * n.x, self.alpha * n.y, n.z.max(0.0)).normalize_or(Vec3::Z)
    }
}
