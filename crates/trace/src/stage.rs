//! Things that move, as they stand and go during an exposure.

use std::sync::Arc;

use fearless_simd::{Simd, dispatch};
use glam::{DAffine3, DVec3};

use crate::bvh::{Bvh, Item, Visitor};
use crate::geometry::{Geometry, SurfaceId};
use crate::mesh_detail::Patches;
use crate::{Body, Exposure, Hit, Motion, Ray, SceneError};

/// The surfaces of a thing in its own space; all copies of it share them.
#[derive(Debug)]
pub(crate) struct Solid {
    pub(crate) geometry: Geometry,
    pub(crate) patches: Patches,
    extent: [DVec3; 2],
}

impl Solid {
    pub(crate) fn new(body: Body) -> Result<Self, SceneError> {
        let extent = body.extent().unwrap_or([DVec3::ZERO; 2]);
        let (geometry, triangle_of) = Geometry::with_indices(body.triangles, body.shapes)?;
        Ok(Self { geometry, patches: Patches::new(body.patches, triangle_of), extent })
    }
}

/// A thing and its way.
#[derive(Debug)]
pub(crate) struct Mover {
    pub(crate) solid: Arc<Solid>,
    pub(crate) motion: Motion,
    /// Where it would stand without its moves.
    rest: DAffine3,
}

impl Mover {
    pub(crate) fn new(solid: &Arc<Solid>, motion: Motion) -> Self {
        Self { solid: Arc::clone(solid), rest: motion.rest(), motion }
    }
}

/// A thing's own space at some time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) world_from_own: DAffine3,
    own_from_world: DAffine3,
}

impl Place {
    fn new(world_from_own: DAffine3) -> Self {
        Self { world_from_own, own_from_world: world_from_own.inverse() }
    }

    fn own_ray(&self, ray: &Ray) -> Ray {
        let origin = self.own_from_world.transform_point3(ray.origin.as_dvec3());
        let direction = self.own_from_world.transform_vector3(ray.direction.as_dvec3());
        Ray::new(origin, direction).timed(ray.time)
    }

    /// What a ray hit in the thing's own space, in the world.
    fn in_world(&self, hit: Hit, mover: u32) -> Hit {
        let normal = (self.own_from_world.matrix3.transpose() * hit.normal).normalize_or(DVec3::Y);
        // A mirrored triangle turns its other side outwards, a mirrored solid does not
        let is_turned = hit.primitive & Geometry::SHAPE == 0 && self.world_from_own.matrix3.determinant() < 0.0;
        let normal = if is_turned { -normal } else { normal };
        Hit { point: self.world_from_own.transform_point3(hit.point), normal, mover, ..hit }
    }
}

/// All things that move during one exposure, in a tree of boxes around their ways.
#[derive(Debug, Default)]
pub(crate) struct Stage {
    bvh: Bvh,
    /// Of each thing that does not move meanwhile.
    still: Vec<Option<Place>>,
}

impl Stage {
    pub(crate) fn new(movers: &[Mover], exposure: &Exposure) -> Self {
        let times = exposure.times();
        let place =
            |mover: &Mover| mover.motion.is_still(times).then(|| Place::new(mover.motion.at(exposure.middle())));
        let still = movers.iter().map(place).collect();
        let item = |(id, mover): (usize, &Mover)| Item {
            bounds: mover.motion.bounds(mover.solid.extent, times),
            id: id as u32,
            alone: true,
        };
        let items = movers.iter().enumerate().map(item).collect();
        Self { bvh: Bvh::build(items, &mut |items| items[0].id), still }
    }

    /// How many things move meanwhile.
    pub(crate) fn moving(&self) -> usize {
        self.still.iter().filter(|place| place.is_none()).count()
    }
}

/// The things of a scene at the times of its exposure.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Things<'a> {
    pub(crate) movers: &'a [Mover],
    pub(crate) stage: &'a Stage,
    pub(crate) exposure: &'a Exposure,
}

impl Things<'_> {
    /// Where a thing is.
    pub(crate) fn place(&self, mover: u32, time: f32) -> Place {
        let still = self.stage.still[mover as usize];
        still.unwrap_or_else(|| Place::new(self.movers[mover as usize].motion.at(self.exposure.frame(time))))
    }

    /// Where a point of a thing would be without its moves: patterns that are fixed there go with it.
    pub(crate) fn resting(&self, hit: &Hit) -> DVec3 {
        let own = self.place(hit.mover, hit.time).own_from_world.transform_point3(hit.point);
        self.movers[hit.mover as usize].rest.transform_point3(own)
    }

    /// The first surface on a ray but `skip`: one of these, or what was found already.
    pub(crate) fn first(&self, geometry: &Geometry, ray: &Ray, skip: SurfaceId, found: Option<Hit>) -> Option<Hit> {
        let mut first = First { things: self, ray, skip, found };
        dispatch!(geometry.level(), simd => self.stage.bvh.walk(simd, ray, &mut first));
        first.found
    }

    /// Whether anything but `skip` lies on a ray before `t_max`.
    pub(crate) fn block(&self, geometry: &Geometry, ray: &Ray, t_max: f64, skip: SurfaceId) -> bool {
        let mut any = Any { things: self, ray, skip, t_max, found: false };
        dispatch!(geometry.level(), simd => self.stage.bvh.walk(simd, ray, &mut any));
        any.found
    }
}

struct First<'a> {
    things: &'a Things<'a>,
    ray: &'a Ray,
    skip: SurfaceId,
    found: Option<Hit>,
}

impl<S: Simd> Visitor<S> for First<'_> {
    fn t_far(&self) -> f32 {
        self.found.as_ref().map_or(f32::MAX, |hit| (hit.t as f32).next_up())
    }

    fn visit(&mut self, _: S, leaf: usize, _: f32) -> bool {
        let mover = leaf as u32;
        let place = self.things.place(mover, self.ray.time);
        let geometry = &self.things.movers[leaf].solid.geometry;
        let hit = geometry.hit_skipping(&place.own_ray(self.ray), self.skip.within(mover));
        if let Some(hit) = hit {
            // Of two at one place what stands still comes first, then the lower number
            let is_first = self.found.as_ref().is_none_or(|found| {
                hit.t < found.t || hit.t == found.t && found.mover != SurfaceId::STILL && mover < found.mover
            });
            if is_first {
                self.found = Some(place.in_world(hit, mover));
            }
        }
        false
    }
}

struct Any<'a> {
    things: &'a Things<'a>,
    ray: &'a Ray,
    skip: SurfaceId,
    t_max: f64,
    found: bool,
}

impl<S: Simd> Visitor<S> for Any<'_> {
    fn t_far(&self) -> f32 {
        (self.t_max as f32).next_up().min(f32::MAX)
    }

    fn visit(&mut self, _: S, leaf: usize, _: f32) -> bool {
        let mover = leaf as u32;
        let ray = self.things.place(mover, self.ray.time).own_ray(self.ray);
        self.found = self.things.movers[leaf].solid.geometry.is_blocked(&ray, self.t_max, self.skip.within(mover));
        self.found
    }
}
