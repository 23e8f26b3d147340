//! All surfaces of a scene, and the two questions asked of them: what is hit first, and is anything in between.

use std::ops::ControlFlow;

use glam::{DVec3, Vec3};

use crate::bounds::Bounds;
use crate::bvh::Bvh;
use crate::shape::PlacedShape;
use crate::triangle::{ShearedRay, Triangle4, TriangleHit};
use crate::{Ray, SceneError};

/// Names a primitive: a triangle, or a shape after the last triangle.
pub(crate) type PrimitiveId = u32;

/// A triangle in the world with its material.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triangle {
    pub(crate) corners: [Vec3; 3],
    pub(crate) material: u32,
}

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
}

/// What lies in one leaf of the tree.
#[derive(Debug, Clone)]
struct Leaf {
    packs: std::ops::Range<u32>,
    shapes: std::ops::Range<u32>,
}

/// Four triangles and their names.
#[derive(Debug, Clone)]
struct Pack {
    triangles: Triangle4,
    ids: [u32; 4],
}

/// Triangles and bounded shapes in one tree, infinite planes beside it.
#[derive(Debug, Clone)]
pub(crate) struct Geometry {
    triangles: Vec<Triangle>,
    shapes: Vec<PlacedShape>,
    endless: Vec<u32>,
    bvh: Bvh,
    leaves: Vec<Leaf>,
    packs: Vec<Pack>,
    leaf_shapes: Vec<u32>,
}

/// The nearest candidate so far.
#[derive(Clone, Copy)]
enum Found {
    Triangle { id: u32, weights: Vec3 },
    Shape { id: u32, normal: DVec3 },
}

impl Geometry {
    pub(crate) fn new(triangles: Vec<Triangle>, shapes: Vec<PlacedShape>) -> Result<Self, SceneError> {
        let count = triangles.len() + shapes.len();
        if count >= (u32::MAX / 2) as usize {
            return Err(SceneError::TooMany(count));
        }
        // Bound everything that ends somewhere
        let mut boxes = Vec::with_capacity(count);
        let mut boxed: Vec<PrimitiveId> = Vec::with_capacity(count);
        for (id, triangle) in triangles.iter().enumerate() {
            let mut bounds = Bounds::EMPTY;
            triangle.corners.iter().for_each(|corner| bounds.include(corner.as_dvec3()));
            boxes.push(bounds.to_aabb());
            boxed.push(id as u32);
        }
        let mut endless = Vec::new();
        for (i, shape) in shapes.iter().enumerate() {
            match shape.bounds() {
                Some(bounds) => {
                    boxes.push(bounds.to_aabb());
                    boxed.push((triangles.len() + i) as u32);
                }
                None => endless.push(i as u32),
            }
        }

        // Lay the primitives out leaf by leaf
        let (bvh, leaf_members) = Bvh::build(&boxes, 4);
        let mut geometry =
            Self { triangles, shapes, endless, bvh, leaves: Vec::new(), packs: Vec::new(), leaf_shapes: Vec::new() };
        for members in leaf_members {
            geometry.add_leaf(members.iter().map(|&member| boxed[member as usize]));
        }
        Ok(geometry)
    }

    fn add_leaf(&mut self, members: impl Iterator<Item = PrimitiveId>) {
        let count = self.triangles.len() as u32;
        let (triangles, shapes): (Vec<u32>, Vec<u32>) = members.partition(|&id| id < count);
        let (first_pack, first_shape) = (self.packs.len() as u32, self.leaf_shapes.len() as u32);
        for ids in triangles.chunks(4) {
            let corners: Vec<_> = ids.iter().map(|&id| self.triangles[id as usize].corners).collect();
            let mut four = [u32::MAX; 4];
            four[..ids.len()].copy_from_slice(ids);
            self.packs.push(Pack { triangles: Triangle4::new(&corners), ids: four });
        }
        self.leaf_shapes.extend(shapes.iter().map(|id| id - count));
        self.leaves.push(Leaf {
            packs: first_pack..self.packs.len() as u32,
            shapes: first_shape..self.leaf_shapes.len() as u32,
        });
    }

    /// The first surface that the ray meets.
    #[inline]
    pub(crate) fn hit(&self, ray: &Ray) -> Option<Hit> {
        self.hit_skipping(ray, None)
    }

    /// The first surface that the ray meets but the triangle `skip`: the one it leaves.
    #[inline]
    pub(crate) fn hit_skipping(&self, ray: &Ray, skip: Option<PrimitiveId>) -> Option<Hit> {
        let skip = skip.unwrap_or(u32::MAX);
        let sheared = ShearedRay::new(ray);
        let mut nearest: Option<(f64, Found)> = None;
        for &id in &self.endless {
            self.try_shape(id, ray, &mut nearest);
        }
        let t_start = nearest.map_or(f32::INFINITY, |(t, _)| up(t));
        self.bvh.traverse(ray, t_start, |leaf, mut t_max| {
            let leaf = &self.leaves[leaf];
            for pack in &self.packs[leaf.packs.start as usize..leaf.packs.end as usize] {
                if let Some(hit) = pack.hit(&sheared, t_max, skip) {
                    let t = f64::from(hit.t);
                    if nearest.is_none_or(|(best, _)| t < best) {
                        nearest = Some((t, Found::Triangle { id: pack.ids[hit.lane], weights: hit.weights }));
                        t_max = hit.t;
                    }
                }
            }
            for &id in &self.leaf_shapes[leaf.shapes.start as usize..leaf.shapes.end as usize] {
                if self.try_shape(id, ray, &mut nearest) {
                    t_max = nearest.map_or(t_max, |(t, _)| up(t));
                }
            }
            ControlFlow::Continue(t_max)
        });
        nearest.map(|(t, found)| self.surface(ray, t, found))
    }

    /// Takes a shape's hit if it is the nearest so far.
    #[inline]
    fn try_shape(&self, id: u32, ray: &Ray, nearest: &mut Option<(f64, Found)>) -> bool {
        let t_max = nearest.map_or(f64::INFINITY, |(t, _)| t);
        let Some((t, normal)) = self.shapes[id as usize].hit(ray, t_max) else { return false };
        *nearest = Some((t, Found::Shape { id, normal }));
        true
    }

    /// The point that was found.
    fn surface(&self, ray: &Ray, t: f64, found: Found) -> Hit {
        match found {
            Found::Triangle { id, weights } => {
                let Triangle { corners, material } = self.triangles[id as usize];
                let [a, b, c] = corners.map(Vec3::as_dvec3);
                // Weights that sum to 1 in double precision keep the point in the triangle's plane
                let (v, w) = (f64::from(weights.y), f64::from(weights.z));
                let point = a + v * (b - a) + w * (c - a);
                let normal = (b - a).cross(c - a).normalize_or(DVec3::Y);
                Hit { t, point, normal, material, primitive: id }
            }
            Found::Shape { id, normal } => {
                let material = self.shapes[id as usize].material;
                Hit { t, point: ray.at(t), normal, material, primitive: self.triangles.len() as u32 + id }
            }
        }
    }

    /// Whether anything but the triangle `skip` lies on the ray before `t_max`.
    pub(crate) fn is_blocked(&self, ray: &Ray, t_max: f64, skip: Option<PrimitiveId>) -> bool {
        if self.endless.iter().any(|&id| self.shapes[id as usize].hit(ray, t_max).is_some()) {
            return true;
        }
        let sheared = ShearedRay::new(ray);
        let skip = skip.unwrap_or(u32::MAX);
        let mut blocked = false;
        self.bvh.traverse(ray, up(t_max), |leaf, t_far| {
            let leaf = &self.leaves[leaf];
            let packs = &self.packs[leaf.packs.start as usize..leaf.packs.end as usize];
            let shapes = &self.leaf_shapes[leaf.shapes.start as usize..leaf.shapes.end as usize];
            blocked = packs.iter().any(|pack| pack.hit(&sheared, t_far, skip).is_some())
                || shapes.iter().any(|&id| self.shapes[id as usize].hit(ray, t_max).is_some());
            if blocked { ControlFlow::Break(()) } else { ControlFlow::Continue(t_far) }
        });
        blocked
    }

    /// The same as [`Self::hit`] by asking every primitive: the oracle of the tree.
    #[cfg(test)]
    pub(crate) fn hit_by_search(&self, ray: &Ray) -> Option<Hit> {
        let sheared = ShearedRay::new(ray);
        let mut nearest: Option<(f64, Found)> = None;
        for id in 0..self.shapes.len() as u32 {
            self.try_shape(id, ray, &mut nearest);
        }
        for (id, triangle) in self.triangles.iter().enumerate() {
            let hit = Triangle4::new(&[triangle.corners]).hit(&sheared, f32::INFINITY);
            if let Some(hit) = hit.filter(|hit| nearest.is_none_or(|(best, _)| f64::from(hit.t) < best)) {
                nearest = Some((f64::from(hit.t), Found::Triangle { id: id as u32, weights: hit.weights }));
            }
        }
        nearest.map(|(t, found)| self.surface(ray, t, found))
    }
}

impl Pack {
    /// The nearest hit of the triangles but `skip` before `t_max`.
    #[inline]
    fn hit(&self, ray: &ShearedRay, t_max: f32, skip: PrimitiveId) -> Option<TriangleHit> {
        let hit = self.triangles.hit(ray, t_max)?;
        if self.ids[hit.lane] == skip { self.triangles.without(hit.lane).hit(ray, t_max) } else { Some(hit) }
    }
}

/// The next single-precision number, so that nothing nearer is cut off.
fn up(t: f64) -> f32 {
    (t as f32).next_up()
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DQuat};

    use super::*;
    use crate::Shape;

    /// A small deterministic generator (SplitMix64) of numbers in [-1, 1).
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn vector(&mut self) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next())
        }
    }

    fn jumble(numbers: &mut Numbers) -> Geometry {
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
                assert!(geometry.is_blocked(&ray, hit.t * 1.0001, None));
                assert!(!geometry.is_blocked(&ray, hit.t * 0.9999, None));
            } else {
                assert!(!geometry.is_blocked(&ray, f64::INFINITY, None));
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
                    let ray = Ray { origin, direction: target - origin };
                    assert!(geometry.hit(&ray).is_some(), "{ray:?} left the ball");
                }
            }
        }
    }
}
