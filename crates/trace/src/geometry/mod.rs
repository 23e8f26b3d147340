//! All surfaces of a scene, and the two questions asked of them: what is hit first, and is anything in between.

mod many;
mod one;
mod pack;

use fearless_simd::{Level, dispatch};
use glam::{DVec3, Vec3};

use crate::bounds::Bounds;
use crate::bvh::{Bvh, Item};
use crate::shape::PlacedShape;
use crate::{Ray, SceneError};
use one::{Anything, Nearest};
use pack::{LANES, Pack};

pub(crate) use many::Search;
pub(crate) use pack::Triangle;

/// Names a primitive: four times its pack and its lane there for a triangle, [`Geometry::SHAPE`] and its number for a
/// shape.
pub(crate) type PrimitiveId = u32;

/// A point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The ray's parameter.
    pub t: f64,
    /// Where, in world space; exact to f64 within the surface.
    pub point: DVec3,
    /// Unit geometric normal on the surface's outer side (counter-clockwise corners, outside of a solid).
    pub normal: DVec3,
    pub(crate) material: u32,
    pub(crate) primitive: PrimitiveId,
    /// Weights of a triangle's second and third corner; 0 of a shape.
    pub(crate) weights: [f32; 2],
    /// The moving thing that it belongs to, or [`SurfaceId::STILL`].
    pub(crate) mover: u32,
    /// When it was met, 0 to 1 from opening to closing of the shutter.
    pub(crate) time: f32,
}

impl Hit {
    /// Which surface it is a point of.
    pub(crate) fn id(&self) -> SurfaceId {
        SurfaceId { mover: self.mover, primitive: self.primitive }
    }
}

/// Names a surface: a primitive of all that stands still, or of a moving thing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SurfaceId {
    pub(crate) mover: u32,
    pub(crate) primitive: PrimitiveId,
}

impl SurfaceId {
    /// In place of the number of a moving thing.
    pub(crate) const STILL: u32 = u32::MAX;
    /// The name of nothing.
    pub(crate) const NONE: Self = Self { mover: Self::STILL, primitive: Geometry::NO_PRIMITIVE };

    /// Its name among the primitives of a moving thing, or of what stands still; that of nothing if it is none of those.
    pub(crate) fn within(self, mover: u32) -> PrimitiveId {
        if self.mover == mover { self.primitive } else { Geometry::NO_PRIMITIVE }
    }
}

/// Triangles and bounded shapes in one tree, infinite planes beside it.
#[derive(Debug, Clone)]
pub(crate) struct Geometry {
    packs: Vec<Pack>,
    shapes: Vec<PlacedShape>,
    endless: Vec<u32>,
    bvh: Bvh,
    level: Level,
}

/// What a leaf of the tree holds.
#[derive(Debug, Clone, Copy)]
enum Leaf {
    Pack(usize),
    Shape(u32),
}

impl Leaf {
    #[inline(always)]
    fn of(number: usize) -> Self {
        let shape = Geometry::SHAPE as usize;
        if number & shape == 0 { Self::Pack(number) } else { Self::Shape((number & !shape) as u32) }
    }
}

/// The first surface so far; of two at the same place the one with the lower number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Found {
    pub(crate) t: f32,
    pub(crate) primitive: PrimitiveId,
    /// Weights of a triangle's second and third corner.
    pub(crate) v: f32,
    pub(crate) w: f32,
}

impl Found {
    /// Nothing at any finite place.
    pub(crate) const NOTHING: Self = Self { t: f32::MAX, primitive: Geometry::NO_PRIMITIVE, v: 0.0, w: 0.0 };

    #[inline(always)]
    fn take(&mut self, other: Self) -> bool {
        let is_first = other.t < self.t || other.t == self.t && other.primitive < self.primitive;
        if is_first {
            *self = other;
        }
        is_first
    }
}

impl Geometry {
    /// Set in the names of shapes.
    pub(crate) const SHAPE: PrimitiveId = 1 << 30;
    /// The name of nothing.
    pub(crate) const NO_PRIMITIVE: PrimitiveId = u32::MAX;
    /// Primitives that surely have names.
    pub(crate) const MOST: usize = (1 << 28) - 1;

    pub(crate) fn new(triangles: Vec<Triangle>, shapes: Vec<PlacedShape>) -> Result<Self, SceneError> {
        Self::build(triangles, shapes, &mut |_| {})
    }

    /// The same, and the index that each named triangle was given by; `u32::MAX` for names without one.
    pub(crate) fn with_indices(
        triangles: Vec<Triangle>,
        shapes: Vec<PlacedShape>,
    ) -> Result<(Self, Vec<u32>), SceneError> {
        let mut index_of = Vec::with_capacity(triangles.len());
        let geometry = Self::build(triangles, shapes, &mut |items| {
            let lane = |lane: usize| items.get(lane).map_or(u32::MAX, |item| item.id);
            index_of.extend((0..LANES).map(lane));
        })?;
        Ok((geometry, index_of))
    }

    /// `each_pack` is told the triangles of each pack.
    fn build(
        triangles: Vec<Triangle>,
        shapes: Vec<PlacedShape>,
        each_pack: &mut dyn FnMut(&[Item]),
    ) -> Result<Self, SceneError> {
        let count = triangles.len() + shapes.len();
        if count > Self::MOST {
            return Err(SceneError::TooMany(count));
        }
        // Bound everything that ends somewhere
        let mut items = Vec::with_capacity(count);
        for (id, triangle) in triangles.iter().enumerate() {
            items.push(Item { bounds: Bounds::around(&triangle.corners), id: id as u32, alone: false });
        }
        let mut endless = Vec::new();
        for (id, shape) in shapes.iter().enumerate() {
            match shape.bounds() {
                Some(bounds) => items.push(Item { bounds, id: id as u32, alone: true }),
                None => endless.push(id as u32),
            }
        }

        // Lay the triangles out leaf by leaf
        let mut packs = Vec::with_capacity(triangles.len() / 3 + 1);
        let bvh = Bvh::build(items, &mut |items| {
            if items[0].alone {
                return Self::SHAPE | items[0].id;
            }
            each_pack(items);
            packs.push(Pack::new(items.iter().map(|item| &triangles[item.id as usize])));
            (packs.len() - 1) as u32
        });
        packs.shrink_to_fit();
        Ok(Self { packs, shapes, endless, bvh, level: Level::new() })
    }

    /// The first surface that the ray meets.
    #[cfg(test)]
    pub(crate) fn hit(&self, ray: &Ray) -> Option<Hit> {
        self.hit_skipping(ray, Self::NO_PRIMITIVE)
    }

    /// The first surface that the ray meets but the triangle `skip`: the one it leaves.
    pub(crate) fn hit_skipping(&self, ray: &Ray, skip: PrimitiveId) -> Option<Hit> {
        let mut nearest = Nearest::new(self, ray, skip);
        self.endless.iter().for_each(|&id| nearest.try_shape(id, 0.0));
        dispatch!(self.level, simd => self.bvh.walk(simd, ray, &mut nearest));
        self.surface(ray, &nearest.found)
    }

    /// The point that was found, if any was.
    pub(crate) fn surface(&self, ray: &Ray, found: &Found) -> Option<Hit> {
        let primitive = found.primitive;
        if primitive == Self::NO_PRIMITIVE {
            return None;
        }
        if primitive & Self::SHAPE != 0 {
            let shape = &self.shapes[(primitive & !Self::SHAPE) as usize];
            let (t, normal) = shape.hit(ray, f64::INFINITY)?;
            let (point, material) = (ray.at(t), shape.material);
            let (mover, time) = (SurfaceId::STILL, ray.time);
            return Some(Hit { t, point, normal, material, primitive, weights: [0.0; 2], mover, time });
        }
        let Triangle { corners, material } = self.triangle(primitive);
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        // Weights that sum to 1 in double precision keep the point in the triangle's plane
        let point = a + f64::from(found.v) * (b - a) + f64::from(found.w) * (c - a);
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Y);
        let (t, weights) = (f64::from(found.t), [found.v, found.w]);
        Some(Hit { t, point, normal, material, primitive, weights, mover: SurfaceId::STILL, time: ray.time })
    }

    /// A triangle by its name.
    #[inline]
    pub(crate) fn triangle(&self, primitive: PrimitiveId) -> Triangle {
        self.packs[primitive as usize / LANES].triangle(primitive as usize % LANES)
    }

    /// The shapes by their numbers.
    pub(crate) fn shapes(&self) -> &[PlacedShape] {
        &self.shapes
    }

    /// Uses other vector instructions.
    #[cfg(test)]
    pub(crate) fn set_level(&mut self, level: Level) {
        self.level = level;
    }

    /// The vector instructions that it uses.
    pub(crate) fn level(&self) -> Level {
        self.level
    }

    /// Whether anything but the triangle `skip` lies on the ray before `t_max`.
    pub(crate) fn is_blocked(&self, ray: &Ray, t_max: f64, skip: PrimitiveId) -> bool {
        if self.endless.iter().any(|&id| self.shapes[id as usize].hit(ray, t_max).is_some()) {
            return true;
        }
        let mut anything = Anything::new(self, ray, t_max, skip);
        dispatch!(self.level, simd => self.bvh.walk(simd, ray, &mut anything));
        anything.found
    }

    /// Bytes that surfaces and tree occupy.
    pub(crate) fn bytes(&self) -> usize {
        self.bvh.bytes() + self.packs.capacity() * size_of::<Pack>() + self.shapes.capacity() * size_of::<PlacedShape>()
    }

    /// The same as [`Self::hit`] by asking every primitive: the oracle of the tree.
    #[cfg(test)]
    pub(crate) fn hit_by_search(&self, ray: &Ray) -> Option<Hit> {
        let mut nearest = Nearest::new(self, ray, Self::NO_PRIMITIVE);
        (0..self.shapes.len() as u32).for_each(|id| nearest.try_shape(id, 0.0));
        for index in 0..self.packs.len() {
            dispatch!(self.level, simd => nearest.try_pack(simd, index, 0.0));
        }
        self.surface(ray, &nearest.found)
    }
}

#[cfg(test)]
mod packet_laws;

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DQuat};

    use super::*;
    use crate::Shape;

    /// A small deterministic generator (SplitMix64) of numbers in [-1, 1).
    pub(super) struct Numbers(pub(super) u64);

    impl Numbers {
        pub(super) fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        pub(super) fn vector(&mut self) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next())
        }
    }

    pub(super) fn jumble(numbers: &mut Numbers) -> Geometry {
        let triangles = (0..600)
            .map(|_| {
                let centre = 4.0 * numbers.vector();
                let corners = [0, 1, 2].map(|_| (centre + 0.5 * numbers.vector()).as_vec3());
                Triangle { corners, material: 0 }
            })
            .collect();
        let kinds = [Shape::Cuboid, Shape::Sphere, Shape::Cylinder, Shape::Cone, Shape::Rectangle];
        let mut shapes: Vec<_> = (0..60)
            .map(|i| {
                let turn = DQuat::from_axis_angle(numbers.vector().normalize(), 3.0 * numbers.next());
                let scale = DVec3::splat(0.4) + 0.3 * numbers.vector();
                let map = DAffine3::from_scale_rotation_translation(scale, turn, 4.0 * numbers.vector());
                PlacedShape::new(kinds[i % 5], map, 0).unwrap()
            })
            .collect();
        let floor = DAffine3::from_translation(DVec3::new(0.0, -5.0, 0.0));
        shapes.push(PlacedShape::new(Shape::Plane, floor, 0).unwrap());
        Geometry::new(triangles, shapes).unwrap()
    }

    #[test]
    fn the_tree_finds_what_a_search_through_everything_finds() {
        let mut numbers = Numbers(1);
        let geometry = jumble(&mut numbers);
        let mut hits = 0;
        for i in 0..20_000 {
            let mut direction = numbers.vector();
            // Let some rays run along the axes, where a slab test divides by 0
            match i % 10 {
                0 => direction = DVec3::X.copysign(direction),
                1 => direction.y = 0.0,
                _ => {}
            }
            let ray = Ray::new(6.0 * numbers.vector(), direction);
            let (fast, plain) = (geometry.hit(&ray), geometry.hit_by_search(&ray));
            assert_eq!(fast, plain, "{ray:?}");
            hits += usize::from(fast.is_some());
            // What is hit blocks every ray that goes farther, and none that ends before
            if let Some(hit) = fast {
                assert!(geometry.is_blocked(&ray, hit.t * 1.0001, Geometry::NO_PRIMITIVE));
                assert!(!geometry.is_blocked(&ray, hit.t * 0.9999, Geometry::NO_PRIMITIVE));
            } else {
                assert!(!geometry.is_blocked(&ray, f64::INFINITY, Geometry::NO_PRIMITIVE));
            }
        }
        assert!((4_000..20_000).contains(&hits), "{hits} of 20000 rays hit: the test would say little");
    }

    #[test]
    fn no_ray_slips_between_triangles_that_share_an_edge() {
        // A closed ball of triangles seen from inside through its vertices, edge midpoints and near them
        let mut numbers = Numbers(2);
        let (parallels, meridians) = (12, 24);
        let vertex = |i: usize, j: usize| {
            let (polar, turn) = (
                std::f32::consts::PI * i as f32 / parallels as f32,
                std::f32::consts::TAU * (j % meridians) as f32 / meridians as f32,
            );
            Vec3::new(polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin())
        };
        let mut triangles = Vec::new();
        for i in 0..parallels {
            for j in 0..meridians {
                let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
                triangles.push(Triangle { corners: [a, b, c], material: 0 });
                triangles.push(Triangle { corners: [a, c, d], material: 0 });
            }
        }
        let geometry = Geometry::new(triangles.clone(), Vec::new()).unwrap();
        for _ in 0..300 {
            let origin = (0.3 * numbers.vector()).as_vec3();
            for triangle in &triangles {
                let [a, b, c] = triangle.corners;
                for target in [a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.25 * a + 0.75 * c] {
                    let ray = Ray::single(origin, target - origin);
                    assert!(geometry.hit(&ray).is_some(), "{ray:?} left the ball");
                }
            }
        }
    }
}
