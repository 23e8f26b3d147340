//! The cat's eye: what of the iris is left open towards the border of the picture.

use glam::DVec2;

use crate::ApertureShape;

/// The part of the unit opening that lies within a second rim.
///
/// A lens is as long as a tube: seen at an angle, its front or rear rim covers a part of the iris (optical or mechanical
/// vignetting; Kingslake, "Optical System Design", 1983, calls the rest the *cat's eye*). The rim is a disc of radius 1 in
/// the unit opening, moved from the centre by the tangent of the angle; the open part is the intersection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opening {
    pub(crate) shape: ApertureShape,
    pub(crate) rim: DVec2,
}

impl Opening {
    /// How far the rim is moved at most, in radii: beyond, the lens would close, and an iris of three blades does so first.
    pub const LARGEST_SHIFT: f64 = 1.25;

    /// Centre of the rim in the unit opening; at most [`Self::LARGEST_SHIFT`] from the centre.
    #[must_use]
    pub fn rim(&self) -> DVec2 {
        self.rim
    }

    /// Whether a point of the unit opening's plane is open.
    #[must_use]
    pub fn contains(&self, p: DVec2) -> bool {
        self.shape.contains(p) && self.is_within_rim(p)
    }

    /// Whether a point that lies in the unit opening lies within the rim too.
    #[must_use]
    pub fn is_within_rim(&self, p: DVec2) -> bool {
        p.distance_squared(self.rim) <= 1.0
    }

    /// The area that is open, of the unit opening's; pi for a whole disc.
    #[must_use]
    pub fn area(&self) -> f64 {
        match self.shape {
            shape if self.rim == DVec2::ZERO => shape.area(),
            ApertureShape::Disc => {
                // Two segments of the unit circle, each beyond the chord that both circles share
                let chord = 0.5 * self.rim.length();
                2.0 * (chord.acos() - chord * (1.0 - chord * chord).sqrt())
            }
            ApertureShape::Polygon { .. } => {
                let corners: Vec<DVec2> = self.shape.corners().map(|corner| corner - self.rim).collect();
                let next = corners.iter().cycle().skip(1);
                corners.iter().zip(next).map(|(&a, &b)| triangle_within_disc(a, b)).sum()
            }
        }
    }

    /// The share of the unit opening that is open, 0 to 1: by how much a lens whose exposure nobody corrects is darker here.
    #[must_use]
    pub fn share(&self) -> f64 {
        (self.area() / self.shape.area()).min(1.0)
    }
}

/// Signed area that the triangle (0, a, b) and the unit disc share; positive if b is to the left of a.
fn triangle_within_disc(a: DVec2, b: DVec2) -> f64 {
    let sector = |from: DVec2, to: DVec2| 0.5 * from.angle_to(to);
    let triangle = |from: DVec2, to: DVec2| 0.5 * from.perp_dot(to);
    // Where the side a + t (b - a) crosses the circle
    let side = b - a;
    let (half, length_squared) = (-a.dot(side), side.length_squared());
    let root = half * half - length_squared * (a.length_squared() - 1.0);
    if length_squared == 0.0 || root <= 0.0 {
        return sector(a, b);
    }
    let [enter, leave] = [half - root.sqrt(), half + root.sqrt()].map(|t| t / length_squared);
    if leave <= 0.0 || enter >= 1.0 {
        return sector(a, b);
    }
    // Sectors where the side is outside, a triangle where it is inside
    let (first, last) = (a + enter.max(0.0) * side, a + leave.min(1.0) * side);
    let before = if enter > 0.0 { sector(a, first) } else { 0.0 };
    let after = if leave < 1.0 { sector(last, b) } else { 0.0 };
    before + triangle(first, last) + after
}
