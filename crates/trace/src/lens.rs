//! The camera's rays, eight samples at a time.
//!
//! The same rays as [`Camera::world_ray`], rounded to f32 where they are small: what all samples of a pixel share is
//! taken from the camera in double precision. With the samples in lanes too, this took the tracer from 10.9 to 20 million
//! camera samples per 2 CPU seconds (44,716 triangles, `ray_speed`).

use fearless_simd::{f32x8, prelude::*};
use glam::{DVec2, DVec3};
use optics::{ApertureShape, Camera};

/// What all pixels share; directions of the world for a step of one pixel, and for the iris's half axes.
#[derive(Debug, Clone)]
pub(crate) struct Lens<'a> {
    camera: &'a Camera,
    /// The camera's place, in two parts so that it is rounded only together with the lens point.
    place: [[f32; 3]; 2],
    axes: [[f32; 3]; 2],
    steps: [[f32; 3]; 2],
    /// w . (q, 1) for a step.
    focus_steps: [f32; 2],
}

/// What the samples of a pixel share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PixelLens {
    direction: [f32; 3],
    focus: f32,
}

/// Where rays start and go.
pub(crate) struct LaneRays<S: Simd> {
    pub(crate) origin: [f32x8<S>; 3],
    pub(crate) direction: [f32x8<S>; 3],
}

impl<'a> Lens<'a> {
    pub(crate) fn new(camera: &'a Camera) -> Self {
        let world = |d: DVec3| camera.pose.direction_to_world(d).as_vec3().to_array();
        let (iris, sizes) = (&camera.iris, camera.iris.half_sizes());
        let corner = camera.film.q_from_pixel(DVec2::ZERO);
        let steps = [DVec2::X, DVec2::Y].map(|step| (camera.film.q_from_pixel(step) - corner).extend(0.0));
        let place = camera.pose.position;
        let rounded = place.as_vec3();
        Self {
            camera,
            place: [rounded.to_array(), (place - rounded.as_dvec3()).as_vec3().to_array()],
            axes: [world(sizes.x * iris.e1()), world(sizes.y * iris.e2())],
            steps: steps.map(world),
            focus_steps: steps.map(|step| camera.focus.w().dot(step) as f32),
        }
    }

    /// The camera whose rays these are.
    pub(crate) fn camera(&self) -> &'a Camera {
        self.camera
    }

    /// The pixel whose upper left corner is given; `None` where the lens blocks rays of it, or may.
    pub(crate) fn pixel(&self, corner: DVec2) -> Option<PixelLens> {
        if self.camera.iris.cat_eye() > 0.0 {
            return None;
        }
        let q1 = |offset: DVec2| self.camera.film.q_from_pixel(corner + offset).extend(1.0);
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE].map(q1);
        let normal = self.camera.iris.normal();
        corners.iter().all(|&q1| normal.dot(q1) > 0.0).then(|| PixelLens {
            direction: self.camera.pose.direction_to_world(corners[0]).as_vec3().to_array(),
            focus: self.camera.focus.w().dot(corners[0]) as f32,
        })
    }

    /// Rays of a pixel: where in the pixel (x, y) and where on the lens (u, v), all in [0, 1).
    ///
    /// Origin L, direction (q, 1) - w(q) L.
    #[inline(always)]
    pub(crate) fn rays<S: Simd>(&self, simd: S, pixel: &PixelLens, [x, y, u, v]: [f32x8<S>; 4]) -> LaneRays<S> {
        let [a, b] = self.opening(simd, u, v);
        let focus = x * self.focus_steps[0] + y * self.focus_steps[1] + pixel.focus;
        let zero = f32x8::splat(simd, 0.0);
        let (mut origin, mut direction) = ([zero; 3], [zero; 3]);
        for axis in 0..3 {
            let lens = a * self.axes[0][axis] + b * self.axes[1][axis];
            origin[axis] = (lens + self.place[1][axis]) + self.place[0][axis];
            let chief = x * self.steps[0][axis] + y * self.steps[1][axis] + pixel.direction[axis];
            direction[axis] = chief - focus * lens;
        }
        LaneRays { origin, direction }
    }

    /// Points of the opening, the unit disc or what the camera has for one.
    #[inline(always)]
    fn opening<S: Simd>(&self, simd: S, u: f32x8<S>, v: f32x8<S>) -> [f32x8<S>; 2] {
        match self.camera.iris.shape() {
            ApertureShape::Disc => disc(simd, u, v),
            shape @ ApertureShape::Polygon { .. } => {
                let (mut a, mut b) = (u, v);
                for lane in 0..8 {
                    let point = shape.sample(DVec2::new(f64::from(u[lane]), f64::from(v[lane])));
                    (a[lane], b[lane]) = (point.x as f32, point.y as f32);
                }
                [a, b]
            }
        }
    }
}

/// Shirley and Chiu's concentric map of the unit square onto the disc, to 2e-7.
#[inline(always)]
fn disc<S: Simd>(simd: S, u: f32x8<S>, v: f32x8<S>) -> [f32x8<S>; 2] {
    use std::f32::consts::FRAC_PI_4;
    let (x, y) = (u * 2.0 - 1.0, v * 2.0 - 1.0);
    let is_wide = x.abs().simd_gt(y.abs());
    let (radius, other) = (is_wide.select(x, y), is_wide.select(y, x));
    let safe = radius.simd_eq(0.0).select(f32x8::splat(simd, 1.0), radius);
    // Taylor series of sine and cosine up to 45 degrees
    let angle = other / safe * FRAC_PI_4;
    let square = angle * angle;
    let sine = square * (1.0 / 362_880.0) - 1.0 / 5_040.0;
    let sine = ((sine * square + 1.0 / 120.0) * square - 1.0 / 6.0) * square + 1.0;
    let cosine = square * (-1.0 / 3_628_800.0) + 1.0 / 40_320.0;
    let cosine = ((cosine * square - 1.0 / 720.0) * square + 1.0 / 24.0) * square - 0.5;
    let (along, across) = (radius * (cosine * square + 1.0), radius * (sine * angle));
    [is_wide.select(along, across), is_wide.select(across, along)]
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use optics::{Film, Focus, Iris, Pose};

    use super::*;

    #[test]
    fn rays_in_lanes_are_the_cameras_rays() {
        /// Rounding of numbers up to 10 in f32, a few times over.
        const ROUNDING: f64 = 4e-6;
        for shape in [ApertureShape::Disc, ApertureShape::polygon(5, 0.3).unwrap()] {
            let iris = Iris::new(DVec3::new(0.1, -0.2, 1.0), 0.4, shape).unwrap().squeezed(1.5).unwrap();
            let camera = Camera {
                pose: Pose::look_at(DVec3::new(7.0, 3.0, -5.0), DVec3::ZERO, DVec3::Y).unwrap(),
                film: Film::from_fov(0.7, 64, 48).unwrap(),
                focus: Focus::new(DVec3::new(0.05, -0.1, 0.16)).unwrap(),
                iris,
            };
            let lens = Lens::new(&camera);
            for (x, y) in [(0.0, 0.0), (63.0, 47.0), (-5.0, 20.0)] {
                let pixel = lens.pixel(DVec2::new(x, y)).unwrap();
                let numbers =
                    [0, 1, 2, 3].map(|k| [0, 1, 2, 3, 4, 5, 6, 7].map(|i| (0.37 * (3 * i + k) as f32).fract()));
                let mut numbers = numbers;
                (numbers[2][0], numbers[3][0]) = (0.5, 0.5); // the lens centre
                let (mut origin, mut direction) = ([[0.0_f32; 8]; 3], [[0.0_f32; 8]; 3]);
                dispatch!(Level::new(), simd => {
                    let rays = lens.rays(simd, &pixel, numbers.map(|n| f32x8::load_array(simd, n)));
                    (origin, direction) = (rays.origin.map(SimdBase::to_array), rays.direction.map(SimdBase::to_array));
                });
                for i in 0..8 {
                    let [sx, sy, u, v] = numbers.map(|n| f64::from(n[i]));
                    let q = camera.film.q_from_pixel(DVec2::new(x + sx, y + sy));
                    let ray = camera.world_ray(q, DVec2::new(u, v), 0.0).unwrap();
                    for axis in 0..3 {
                        assert!((f64::from(origin[axis][i]) - ray.origin[axis]).abs() < ROUNDING, "{shape:?} {i}");
                        assert!(
                            (f64::from(direction[axis][i]) - ray.direction[axis]).abs() < ROUNDING,
                            "{shape:?} {i}"
                        );
                    }
                }
            }
        }
    }
}
