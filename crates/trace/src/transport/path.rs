//! What comes along one ray, by one path of light.
//!
//! Kajiya, "The Rendering Equation" (SIGGRAPH 1986); Veach and Guibas, "Optimally Combining Sampling Techniques for Monte
//! Carlo Rendering" (SIGGRAPH 1995): at each surface a light is asked, and a direction is followed that the surface prefers;
//! where both could have found the same light, each counts by its share of their densities. No path ends by chance: it ends
//! after the stated number of bounces, so that the mean is that of the truncated series, without bias.

use std::f32::consts::PI;

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::surface::SurfacePoint;
use super::{Footprint, Stream, Transport};
use crate::geometry::SurfaceId;
use crate::{Absorption, Hit, MAX_RADIANCE, Ray, Scene};

/// Where a shadow ray to a point of a surface ends, so that it does not meet that surface.
const BEFORE: f64 = 1.0 - 1e-4;

/// What a path has come to.
struct Path<'a> {
    scene: &'a Scene,
    transport: &'a Transport,
    stream: &'a mut Stream,
    footprint: Footprint,
    /// What light from here on counts.
    share: Vec3,
    radiance: Vec3,
    /// What takes away light on the way, inside solid glass.
    medium: Option<Absorption>,
    /// Where the last bounce was, and its density; `None` if the direction was given: by the camera, a mirror or glass.
    bounced: Option<(DVec3, f32)>,
}

impl Transport {
    /// Radiance along a ray.
    pub(crate) fn radiance(&self, scene: &Scene, ray: &Ray, footprint: Footprint, stream: &mut Stream) -> Vec3 {
        let mut path = Path::new(scene, self, stream, footprint);
        let first = path.meet(ray, SurfaceId::NONE);
        path.follow(first, ray.direction.as_dvec3());
        path.counted()
    }

    /// Radiance of a surface seen along `direction`.
    pub(crate) fn shade(
        &self,
        scene: &Scene,
        hit: &Hit,
        direction: DVec3,
        footprint: Footprint,
        stream: &mut Stream,
    ) -> Vec3 {
        let mut path = Path::new(scene, self, stream, footprint);
        path.follow(Some(*hit), direction);
        path.counted()
    }
}

impl<'a> Path<'a> {
    fn new(scene: &'a Scene, transport: &'a Transport, stream: &'a mut Stream, footprint: Footprint) -> Self {
        Self {
            scene,
            transport,
            stream,
            footprint,
            share: Vec3::ONE,
            radiance: Vec3::ZERO,
            medium: None,
            bounced: None,
        }
    }

    /// What the sample counts: a radiance that a sum can hold, whatever light met at a point.
    fn counted(&self) -> Vec3 {
        Vec3::from_array(self.radiance.to_array().map(|x| if x.is_nan() { 0.0 } else { x.clamp(0.0, MAX_RADIANCE) }))
    }

    /// The next surface on a ray; of what is partly there, by chance.
    fn meet(&mut self, ray: &Ray, skip: SurfaceId) -> Option<Hit> {
        let (scene, transport) = (self.scene, self.transport);
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let (footprint, stream) = (self.footprint, &mut *self.stream);
        transport.hit_unless(scene, ray, skip, |hit| {
            let t = (hit.point - origin).dot(direction) / direction.length_squared();
            let alpha = transport.alpha(scene, hit, footprint.at(t));
            alpha < 1.0 && (alpha <= 0.0 || stream.chance() >= alpha)
        })
    }

    /// Collects light from surface to surface.
    fn follow(&mut self, first: Option<Hit>, direction: DVec3) {
        let (mut hit, mut direction) = (first, direction);
        for bounce in 0..=self.transport.bounces {
            let Some(at) = hit else { return self.add_sky(direction) };
            let width = self.footprint.at(at.t);
            let point = self.transport.surface(self.scene, &at, direction, width);
            // What is seen from inside of glass was seen through it, wherever the path came from
            if let Some((true, inside)) = point.glass {
                self.medium = inside;
            }
            if let Some(absorption) = self.medium {
                self.share *= absorption.passing(at.t * direction.length());
            }
            self.add_emission(&at, &point);
            let o = point.to_local(-direction);
            self.add_point_lights(&at, &point, o);
            self.add_discs(&at, &point, o, bounce == self.transport.bounces);
            if bounce == self.transport.bounces {
                return;
            }
            let [which, lobe, light_x, light_y] = self.stream.four();
            let [x, y, ..] = self.stream.four();
            if !point.bsdf.is_only_smooth() {
                self.add_light_of_surfaces(&at, &point, o, which, DVec2::new(light_x.into(), light_y.into()));
            }

            // Follow a direction that the surface prefers
            let Some(scattered) = point.bsdf.sample(o, lobe, Vec2::new(x, y)) else { return };
            let next = point.to_world(scattered.direction);
            let is_above = next.dot(point.outward) > 0.0;
            if is_above != (scattered.direction.z > 0.0) {
                return;
            }
            self.share *= scattered.weight;
            if self.share.max_element() <= 0.0 {
                return;
            }
            if let Some((is_inside, inside)) = point.glass.filter(|_| scattered.direction.z < 0.0) {
                self.medium = if is_inside { None } else { inside };
            }
            self.bounced = (scattered.pdf > 0.0).then_some((at.point, scattered.pdf));
            self.footprint = self.footprint.scattered(at.t, direction.length(), scattered.spread);
            let side = if is_above { point.outward } else { -point.outward };
            hit = self.meet(&Ray::leaving(at.point, side, next).timed(at.time), at.id());
            direction = next;
        }
    }

    /// Adds what comes from infinitely far.
    fn add_sky(&mut self, direction: DVec3) {
        let radiance = self.transport.sky(self.scene, direction);
        let weight = match (self.bounced, &self.transport.environment) {
            (Some((_, pdf)), Some(environment)) if !environment.is_dark() => {
                let light = self.chance_of_environment() * environment.pdf(direction.normalize_or(DVec3::Y));
                self.transport.weighing.met(pdf, light as f32)
            }
            _ => 1.0,
        };
        self.radiance += self.share * radiance * weight;
        let direction = direction.normalize_or(DVec3::Y);
        for disc in self.transport.discs.iter().filter(|disc| disc.contains(direction)) {
            let weight = self.bounced.map_or(1.0, |(_, pdf)| self.transport.weighing.met(pdf, disc.pdf() as f32));
            self.radiance += self.share * disc.radiance * weight;
        }
    }

    /// Adds what a surface emits.
    fn add_emission(&mut self, at: &Hit, point: &SurfacePoint<'_>) {
        if point.emission == Vec3::ZERO {
            return;
        }
        let weight = match self.bounced {
            Some((from, pdf)) => {
                let light = (1.0 - self.chance_of_environment()) * self.transport.emitters.pdf(from, at);
                self.transport.weighing.met(pdf, light as f32)
            }
            None => 1.0,
        };
        self.radiance += self.share * point.emission * weight;
    }

    /// The chance that light is asked of the environment rather than of a surface.
    fn chance_of_environment(&self) -> f64 {
        let has_environment = self.transport.environment.as_ref().is_some_and(|environment| !environment.is_dark());
        match (has_environment, self.transport.emitters.is_empty()) {
            (false, _) => 0.0,
            (true, true) => 1.0,
            (true, false) => 0.5,
        }
    }

    /// Adds ambient light, suns and lights at points.
    fn add_point_lights(&mut self, at: &Hit, point: &SurfacePoint<'_>, o: Vec3) {
        let scene = self.scene;
        let mut sum = point.bsdf.diffuse(o) * scene.ambient;
        let mut add = |toward: DVec3, strength: Vec3, t_max: f64, direction: DVec3| {
            let Some((i, side)) = seen_from(point, toward) else { return };
            // A strength of 1 is an irradiance of pi
            let share = point.bsdf.share(o, i) * PI * strength;
            if share.max_element() > 0.0 {
                let ray = scene.shadow_ray(at.point, side, direction).timed(at.time);
                sum += share * self.transport.shining(scene, &ray, t_max, at.id());
            }
        };
        for &(toward, strength) in &scene.suns {
            add(toward, strength, f64::INFINITY, toward);
        }
        for light in &self.transport.points {
            let way = light.at - at.point;
            let distance = way.length();
            if distance > 0.0 {
                let cone = light.cone.map_or(1.0, |cone| cone.share(-way / distance));
                let strength = light.strength * (cone / (distance * distance)) as f32;
                add(way / distance, strength, BEFORE, way);
            }
        }
        self.radiance += self.share * sum;
    }

    /// Adds the light of suns that have a size; after the last bounce no path can meet them any more.
    fn add_discs(&mut self, at: &Hit, point: &SurfacePoint<'_>, o: Vec3, is_last: bool) {
        let transport = self.transport;
        for disc in &transport.discs {
            let [x, y, ..] = self.stream.four();
            let toward = disc.sample(DVec2::new(x.into(), y.into()));
            let Some((i, side)) = seen_from(point, toward) else { continue };
            let share = point.bsdf.share(o, i) * disc.radiance;
            if share.max_element() <= 0.0 {
                continue;
            }
            let ray = self.scene.shadow_ray(at.point, side, toward).timed(at.time);
            let passing = transport.passing(self.scene, &ray, f64::INFINITY, at.id());
            let pdf = disc.pdf();
            let weight = if is_last { 1.0 / pdf } else { transport.weighing.asked(pdf, point.bsdf.pdf(o, i).into()) };
            self.radiance += self.share * share * (f64::from(passing) * weight) as f32;
        }
    }

    /// Adds the light of one point of an emitting surface, or of one direction of the environment.
    fn add_light_of_surfaces(&mut self, at: &Hit, point: &SurfacePoint<'_>, o: Vec3, which: f32, u: DVec2) {
        let chance = self.chance_of_environment();
        let which = f64::from(which);
        let (toward, way, t_max, pdf, radiance) = match &self.transport.environment {
            Some(environment) if which < chance => {
                let (direction, pdf) = environment.sample(u);
                (direction, direction, f64::INFINITY, chance * pdf, environment.radiance(direction))
            }
            _ if self.transport.emitters.is_empty() => return,
            _ => {
                let which = (which - chance) / (1.0 - chance);
                let Some(chosen) = self.transport.emitters.sample(at.point, which, u) else { return };
                let way = chosen.hit.point - at.point;
                let radiance = self.transport.emission(self.scene, &chosen.hit, 0.0);
                let Some(toward) = way.try_normalize() else { return };
                (toward, way, BEFORE, (1.0 - chance) * chosen.pdf, radiance)
            }
        };
        let Some((i, side)) = seen_from(point, toward).filter(|_| pdf > 0.0) else { return };
        let mut share = point.bsdf.share(o, i) * radiance;
        // Light from within glass loses on its way too
        let beyond = match point.glass {
            Some((is_inside, inside)) if i.z < 0.0 => {
                if is_inside {
                    None
                } else {
                    inside
                }
            }
            _ => self.medium,
        };
        if let Some(absorption) = beyond.filter(|_| t_max.is_finite()) {
            share *= absorption.passing(way.length());
        }
        if share.max_element() <= 0.0 {
            return;
        }
        let ray = Ray::leaving(at.point, side, way).timed(at.time);
        let passing = self.transport.passing(self.scene, &ray, t_max, at.id());
        let weight = self.transport.weighing.asked(pdf, point.bsdf.pdf(o, i).into());
        self.radiance += self.share * share * (f64::from(passing) * weight) as f32;
    }
}

/// A unit direction as a surface sees it, and the normal on its side; `None` where bent normals put it on another side than
/// the surface itself does.
fn seen_from(point: &SurfacePoint<'_>, toward: DVec3) -> Option<(Vec3, DVec3)> {
    let i = point.to_local(toward);
    let height = toward.dot(point.outward);
    let side = if height > 0.0 { point.outward } else { -point.outward };
    ((height > 0.0) == (i.z > 0.0) && height != 0.0).then_some((i, side))
}
