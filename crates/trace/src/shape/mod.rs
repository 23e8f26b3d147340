//! Analytic shapes: each is one canonical shape under an affine map, intersected in double precision.

mod cone;
mod cuboid;
mod cylinder;
mod plane;
mod quadratic;
mod sphere;

use glam::{DAffine3, DVec3};

use crate::{Ray, SceneError, bounds::Bounds};

/// A canonical shape. All but the planes are closed solids whose normals point outwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Shape {
    /// The infinite plane y = 0; its normal is +y.
    Plane,
    /// The square |x| <= 1, |z| <= 1 in the plane y = 0; its normal is +y.
    Rectangle,
    /// The cube [-1, 1]^3.
    Cuboid,
    /// The ball of radius 1 around the origin.
    Sphere,
    /// The closed cylinder of radius 1 around the y axis, from y = 0 to y = 1.
    Cylinder,
    /// The closed cone with a base of radius 1 at y = 0 and its tip at y = 1.
    Cone,
}

/// Where a line meets a canonical shape first: the parameter (> 0) and the outward normal, of any length.
pub(crate) type LocalHit = Option<(f64, DVec3)>;

impl Shape {
    /// The first hit with t in (0, `t_max`) of the line `origin + t direction`, in the shape's own space.
    fn hit(self, origin: DVec3, direction: DVec3, t_max: f64) -> LocalHit {
        let hit = match self {
            Self::Plane => plane::hit(origin, direction),
            Self::Rectangle => plane::hit_square(origin, direction),
            Self::Cuboid => cuboid::hit(origin, direction),
            Self::Sphere => sphere::hit(origin, direction),
            Self::Cylinder => cylinder::hit(origin, direction),
            Self::Cone => cone::hit(origin, direction),
        };
        hit.filter(|&(t, _)| t < t_max)
    }

    /// The box around the canonical shape, `None` if it is infinite.
    fn local_bounds(self) -> Option<(DVec3, DVec3)> {
        match self {
            Self::Plane => None,
            Self::Rectangle => Some((DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 0.0, 1.0))),
            Self::Cuboid | Self::Sphere => Some((DVec3::NEG_ONE, DVec3::ONE)),
            Self::Cylinder | Self::Cone => Some((DVec3::new(-1.0, 0.0, -1.0), DVec3::ONE)),
        }
    }
}

/// A canonical shape placed in the world.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedShape {
    shape: Shape,
    world_from_local: DAffine3,
    local_from_world: DAffine3,
    pub(crate) material: u32,
}

impl PlacedShape {
    /// Places a shape; the map must be finite and invertible.
    pub(crate) fn new(shape: Shape, world_from_local: DAffine3, material: u32) -> Result<Self, SceneError> {
        let local_from_world = world_from_local.inverse();
        if !(world_from_local.is_finite() && local_from_world.is_finite()) {
            return Err(SceneError::FlatPlacement);
        }
        Ok(Self { shape, world_from_local, local_from_world, material })
    }

    /// What it is, and where.
    pub(crate) fn placed(&self) -> (Shape, &DAffine3) {
        (self.shape, &self.world_from_local)
    }

    /// The first hit with t in (0, `t_max`), and the unit normal in world space.
    #[inline]
    pub(crate) fn hit(&self, ray: &Ray, t_max: f64) -> Option<(f64, DVec3)> {
        let origin = self.local_from_world.transform_point3(ray.origin.as_dvec3());
        let direction = self.local_from_world.transform_vector3(ray.direction.as_dvec3());
        let (t, normal) = self.shape.hit(origin, direction, t_max)?;
        // Normals go by the transposed inverse
        let normal = self.local_from_world.matrix3.transpose() * normal;
        Some((t, normal.normalize()))
    }

    /// The corners of a box around it in the world, `None` if it is infinite.
    pub(crate) fn corners(&self) -> Option<[DVec3; 8]> {
        let (low, high) = self.shape.local_bounds()?;
        Some([0, 1, 2, 3, 4, 5, 6, 7].map(|corner: usize| {
            let pick = |bit: usize, axis: usize| if corner >> bit & 1 == 1 { high[axis] } else { low[axis] };
            self.world_from_local.transform_point3(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)))
        }))
    }

    /// The box around it in the world, `None` if it is infinite.
    pub(crate) fn bounds(&self) -> Option<Bounds> {
        Some(Bounds::around_exact(&self.corners()?))
    }
}
