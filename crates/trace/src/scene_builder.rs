//! From parts to a scene.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};

use crate::geometry::Geometry;
use crate::mesh_detail::{Patch, Patches};
use crate::stage::{Mover, Solid, Stage};
use crate::transport::{Disc, Parts, PointLight, Transport};
use crate::{
    Alpha, Body, Environment, Exposure, Finish, Light, MAX_RADIANCE, Material, Matter, MeshDetail, Motion, Scene,
    SceneError, Shape,
};

/// Bounces that are taken where something needs any and nobody says how many.
pub(crate) const DEFAULT_BOUNCES: u32 = 8;
/// The most bounces.
const MOST_BOUNCES: u32 = 1024;

/// Collects the parts of a [`Scene`].
#[derive(Debug, Clone, Default)]
pub struct SceneBuilder {
    still: Body,
    bodies: Vec<Body>,
    moving: Vec<(BodyId, Motion)>,
    materials: Vec<Material>,
    finishes: Vec<Finish>,
    lights: Vec<Light>,
    environment: Option<Environment>,
    bounces: Option<u32>,
    sky: Vec3,
    shadow_bias: f64,
    metres_per_unit: Option<f64>,
}

/// A material of a [`SceneBuilder`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MaterialId(pub(crate) u32);

/// A thing of a [`SceneBuilder`] that moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BodyId(usize);

impl SceneBuilder {
    /// An empty, black scene.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a material.
    pub fn material(&mut self, material: Material) -> MaterialId {
        self.finished(material, Finish::default())
    }

    /// Adds a material with more to it than colours.
    pub fn finished(&mut self, material: Material, finish: Finish) -> MaterialId {
        self.materials.push(material);
        self.finishes.push(finish);
        MaterialId((self.materials.len() - 1) as u32)
    }

    /// Adds a canonical shape under an affine map, which must be finite and invertible.
    pub fn shape(&mut self, shape: Shape, world_from_local: DAffine3, material: MaterialId) -> Result<(), SceneError> {
        self.still.shape(shape, world_from_local, material)
    }

    /// Adds triangles that stand still, as [`Body::mesh`] does.
    pub fn mesh(
        &mut self,
        vertices: &[DVec3],
        corners: &[[u32; 3]],
        materials: impl Fn(usize) -> MaterialId,
        world_from_local: DAffine3,
    ) -> Result<usize, SceneError> {
        self.still.mesh(vertices, corners, materials, world_from_local)
    }

    /// Adds triangles that stand still, as [`Body::detailed_mesh`] does.
    pub fn detailed_mesh(
        &mut self,
        vertices: &[DVec3],
        corners: &[[u32; 3]],
        materials: impl Fn(usize) -> MaterialId,
        world_from_local: DAffine3,
        detail: &Arc<MeshDetail>,
    ) -> Result<usize, SceneError> {
        self.still.detailed_mesh(vertices, corners, materials, world_from_local, detail)
    }

    /// All that stands still.
    pub(crate) fn still(&mut self) -> &mut Body {
        &mut self.still
    }

    /// Adds a thing that can be put into the scene with [`Self::moving`], once or many times.
    pub fn body(&mut self, body: Body) -> BodyId {
        self.bodies.push(body);
        BodyId(self.bodies.len() - 1)
    }

    /// Puts a thing into the scene that moves; nothing of it may be endless. What it emits is seen, and lights what paths
    /// happen to come from; it is not asked for light.
    pub fn moving(&mut self, body: BodyId, motion: Motion) -> Result<(), SceneError> {
        let Some([low, high]) = self.bodies[body.0].extent() else { return Err(SceneError::EndlessMover) };
        if !self.bodies[body.0].is_empty() {
            motion.check(low.abs().max(high.abs()).length())?;
            self.moving.push((body, motion));
        }
        Ok(())
    }

    /// Lets light come from infinitely far as a picture of all directions says, instead of the sky.
    pub fn environment(&mut self, environment: Environment) {
        self.environment = Some(environment);
    }

    /// Says how often light goes from surface to surface, at most 1024 times. Otherwise it does 8 times where a material or
    /// light needs it, else never; with 0 what is glossy or glass looks matte.
    pub fn bounces(&mut self, bounces: u32) -> Result<(), SceneError> {
        if bounces > MOST_BOUNCES {
            let value = f64::from(bounces);
            return Err(SceneError::OutOfRange { what: "number of bounces", value, wanted: "at most 1024" });
        }
        self.bounces = Some(bounces);
        Ok(())
    }

    /// Adds a light.
    pub fn light(&mut self, light: Light) {
        self.lights.push(light);
    }

    /// Sets the radiance of what is infinitely far away.
    pub fn sky(&mut self, radiance: Vec3) {
        self.sky = radiance;
    }

    /// Starts shadow rays off the surface by `share` x (1 + the point's largest coordinate).
    ///
    /// The default 0 is exact. Other renderers use a bias against self-shadowing (Mitsuba 3: 8.9e-5), which shortens
    /// the shadows of things that touch; with the same bias their pictures can be compared.
    pub fn shadow_bias(&mut self, share: f64) -> Result<(), SceneError> {
        if !(0.0..=1.0).contains(&share) {
            return Err(SceneError::OutOfRange { what: "shadow bias", value: share, wanted: "0 to 1" });
        }
        self.shadow_bias = share;
        Ok(())
    }

    /// Says how many metres one scene unit is.
    pub fn metres_per_unit(&mut self, metres: f64) -> Result<(), SceneError> {
        positive("metres per unit", metres)?;
        self.metres_per_unit = Some(metres);
        Ok(())
    }

    /// The scene; every colour and light must be finite and not negative, and no surface brighter than
    /// [`MAX_RADIANCE`].
    pub fn build(self) -> Result<Scene, SceneError> {
        let mut total = Vec3::ZERO;
        for light in &self.lights {
            not_negative("strength of a light", light.strength())?;
            if !matches!(light, Light::Point { .. }) {
                total += light.strength();
            }
        }
        not_negative("radiance of the sky", self.sky)?;
        not_too_bright("radiance of the sky", self.sky.max_element())?;
        for material in &self.materials {
            match material.pigment {
                crate::Pigment::Constant(color) => not_negative("color of a material", color)?,
                crate::Pigment::Checker { colors, side, axes } => {
                    not_negative("color of a checker", colors[0])?;
                    not_negative("color of a checker", colors[1])?;
                    positive("side of a checker's tiles", side)?;
                    if axes.iter().any(|&axis| axis > 2) {
                        let value = axes[0].max(axes[1]) as f64;
                        return Err(SceneError::OutOfRange { what: "axis of a checker", value, wanted: "0, 1 or 2" });
                    }
                }
            }
            not_negative("emission of a material", material.emission)?;
            not_too_bright("radiance of a material", material.brightest(total.max_element()))?;
        }
        for finish in &self.finishes {
            check_finish(finish)?;
        }
        let (bounces, reasons) = self.needs();
        let double_sided = self.finishes.iter().map(|finish| finish.is_double_sided).collect();
        let mut ambient = Vec3::ZERO;
        let (mut suns, mut points, mut discs) = (Vec::new(), Vec::new(), Vec::new());
        for light in self.lights {
            match light {
                Light::Ambient { strength } => ambient += strength,
                Light::Sun { toward, strength } => suns.push((toward, strength)),
                Light::Disc { toward, strength, radius } => {
                    let disc = Disc::new(toward, strength, radius);
                    not_too_bright("radiance of a sun of that size", disc.radiance.max_element())?;
                    discs.push(disc);
                }
                Light::Point { at, strength, cone } => points.push(PointLight { at, strength, cone }),
            }
        }
        let Body { triangles, shapes, patches } = self.still;
        let (geometry, transport) = if reasons.is_empty() {
            (Geometry::new(triangles, shapes)?, None)
        } else {
            let (geometry, triangle_of) = Geometry::with_indices(triangles, shapes)?;
            let (finishes, patches, environment) =
                (self.finishes, Patches::new(patches, triangle_of), self.environment);
            let parts = Parts { finishes, patches, points, discs, environment, bounces, reasons };
            let emission: Vec<Vec3> = self.materials.iter().map(|material| material.emission).collect();
            let transport = Transport::new(parts, &geometry, &emission);
            (geometry, Some(Arc::new(transport)))
        };
        let solids = self.bodies.into_iter().map(|body| Ok(Arc::new(Solid::new(body)?)));
        let solids = solids.collect::<Result<Vec<_>, SceneError>>()?;
        let mover = |(body, motion): (BodyId, Motion)| Mover::new(&solids[body.0], motion);
        let movers: Arc<[Mover]> = self.moving.into_iter().map(mover).collect();
        let exposure = Exposure::default();
        let stage = Arc::new(Stage::new(&movers, &exposure));
        Ok(Scene {
            geometry: Arc::new(geometry),
            movers,
            stage,
            exposure,
            materials: self.materials,
            ambient,
            suns,
            sky: self.sky,
            shadow_bias: self.shadow_bias,
            metres_per_unit: self.metres_per_unit,
            transport,
            double_sided,
        })
    }

    /// How many bounces the scene takes, and what of it needs more than the base shading, in words: one example of each kind.
    pub(crate) fn needs(&self) -> (u32, Vec<String>) {
        // Only what is used counts
        let mut is_used = vec![false; self.materials.len()];
        let moving = self.moving.iter().map(|(body, _)| &self.bodies[body.0]);
        let bodies: Vec<&Body> = moving.chain([&self.still]).collect();
        bodies.iter().flat_map(|body| body.materials()).for_each(|i| is_used[i as usize] = true);
        let has = |is_one: fn(&Patch) -> bool| bodies.iter().any(|body| body.patches.iter().any(is_one));
        let used = || (0..self.materials.len()).filter(|&i| is_used[i]);
        let finish = |is_one: &dyn Fn(&Finish) -> bool| used().map(|i| &self.finishes[i]).find(|finish| is_one(finish));
        let mut reasons = Vec::new();
        let mut add = |what: &str, found: Option<&Finish>| {
            if let Some(finish) = found {
                let name = if finish.name.is_empty() { String::new() } else { format!(" '{}'", finish.name) };
                reasons.push(format!("{what}{name}"));
            }
        };

        // What makes light go from surface to surface
        if self.bounces != Some(0) {
            add("glossy material", finish(&|finish| matches!(finish.matter, Matter::Glossy { .. })));
            add("glass material", finish(&|finish| matches!(finish.matter, Matter::Glass { .. })));
            let lamp = used().find(|&i| self.finishes[i].is_light && self.materials[i].emission != Vec3::ZERO);
            add("area light", lamp.map(|i| &self.finishes[i]));
            if self.environment.is_some() {
                reasons.push("environment map".to_owned());
            }
        }
        if self.bounces.is_some_and(|bounces| bounces > 0) {
            reasons.push("bounces asked for".to_owned());
        }
        let bounces = if reasons.is_empty() { 0 } else { self.bounces.unwrap_or(DEFAULT_BOUNCES) };

        // What rays must be traced one by one for
        let mut add = |what: &str, found: Option<&Finish>| {
            if let Some(finish) = found {
                reasons.push(if finish.name.is_empty() {
                    what.to_owned()
                } else {
                    format!("{what} '{}'", finish.name)
                });
            }
        };
        add("textured material", finish(&|finish| finish.maps().next().is_some()));
        add("material with holes", finish(&|finish| finish.alpha != Alpha::Opaque));
        if has(Patch::is_smooth) {
            reasons.push("smooth normals".to_owned());
        }
        if has(Patch::is_colored) {
            reasons.push("colours at vertices".to_owned());
        }
        if self.lights.iter().any(|light| matches!(light, Light::Point { .. })) {
            reasons.push("point light".to_owned());
        }
        if self.lights.iter().any(|light| matches!(light, Light::Disc { .. })) {
            reasons.push("sun of a size".to_owned());
        }
        match self.moving.len() {
            0 => {}
            1 => reasons.push("a moving thing".to_owned()),
            count => reasons.push(format!("{count} moving things")),
        }
        if self.bounces == Some(0) && self.environment.is_some() {
            reasons.push("environment map, seen only".to_owned());
        }
        (bounces, reasons)
    }
}

/// Fails for numbers that a finish cannot have.
fn check_finish(finish: &Finish) -> Result<(), SceneError> {
    let within = |what: &'static str, value: f32, [least, most]: [f32; 2], wanted: &'static str| {
        let is_within = (least..=most).contains(&value);
        if is_within { Ok(()) } else { Err(SceneError::OutOfRange { what, value: f64::from(value), wanted }) }
    };
    match finish.matter {
        Matter::Matte => {}
        Matter::Glossy { metallic, roughness, ior } => {
            within("share of metal", metallic, [0.0, 1.0], "0 to 1")?;
            within("roughness", roughness, [0.0, 1.0], "0 to 1")?;
            within("refractive index", ior, [1.0, 4.0], "1 to 4")?;
        }
        Matter::Glass { ior, roughness, .. } => {
            within("refractive index", ior, [1.0, 4.0], "1 to 4")?;
            within("roughness", roughness, [0.0, 1.0], "0 to 1")?;
        }
    }
    within("opacity", finish.opacity, [0.0, 1.0], "0 to 1")
}

fn positive(what: &'static str, value: f64) -> Result<(), SceneError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(SceneError::OutOfRange { what, value, wanted: "positive and finite" })
}

fn not_negative(what: &'static str, color: Vec3) -> Result<(), SceneError> {
    match color.to_array().into_iter().find(|&x| !(x >= 0.0 && x.is_finite())) {
        Some(value) => Err(SceneError::OutOfRange { what, value: f64::from(value), wanted: "0 or more, and finite" }),
        None => Ok(()),
    }
}

fn not_too_bright(what: &'static str, value: f32) -> Result<(), SceneError> {
    if value <= MAX_RADIANCE {
        return Ok(());
    }
    Err(SceneError::OutOfRange { what, value: f64::from(value), wanted: "at most 262144; use a larger unit of light" })
}
