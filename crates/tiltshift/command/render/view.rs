//! What is seen of a scene, where the command line says it otherwise.

use anyhow::{Context, anyhow};
use glam::DVec2;
use optics::{Camera, Film, Pose};
use trace::{Ray, Scene, Shot};

use crate::console::say;
use crate::focus_wish::Seen;
use crate::lens_options::{FilmOptions, LensOptions};
use crate::values::{Pixel, Size};

/// Width of the sensor where nobody gives one: full frame.
const SENSOR_MM: f64 = 36.0;

/// The shot through the lens that was asked for, of a film of this size; a shot of a model keeps its vertical field of view.
pub(crate) fn seen(
    shot: &Shot,
    scene: &Scene,
    film_options: &FilmOptions,
    lens_options: &LensOptions,
    size: Option<Size>,
    is_model: bool,
) -> anyhow::Result<Shot> {
    film_options.check()?;
    lens_options.check()?;
    let mut shot = shot.clone();
    if let (Some(Size { width, height }), true) = (size, is_model) {
        shot.camera.film = of_shape(shot.camera.film, width, height)?;
    }
    let film = shot.camera.film;
    let film_options = &film_options.settled(lens_options, film.width(), film.height(), 1.0)?;
    if let Some(other) = film_options.film(film.width(), film.height(), 1.0)? {
        shot.camera.film = other;
        shot.lens = None;
        shot.exposure = shot.exposure.with_held_lens();
    }
    if !lens_options.is_given() {
        return Ok(shot);
    }

    // Find out what the lens does not say: focal length and focus
    let metres = scene.metres_per_unit();
    let metres = metres.ok_or_else(|| anyhow!("a lens needs the scene's unit: metres_per_unit in its file"))?;
    let film = shot.camera.film;
    let focal_length_mm = film_options.focal_length_mm().or(shot.lens.map(|lens| 1e3 * metres * lens.focal_length()));
    let from_film = film_options.sensor_width.unwrap_or(SENSOR_MM) / (film.max() - film.min()).x;
    let mut lens_options = lens_options.clone();
    let is_focused = lens_options.is_focused();
    if !is_focused {
        lens_options.focus_pixel = Some(Pixel { x: (film.width() / 2) as i32, y: (film.height() / 2) as i32 });
    }
    let pose = shot.camera.pose;
    let seen = SceneDepths { scene, pose, film, metres };
    let focal_length_mm = Some(focal_length_mm.unwrap_or(from_film));
    let chosen = lens_options.camera(pose, film, focal_length_mm, metres, &seen)?;
    let (camera, lens) = (Camera { film, ..chosen.camera }, Some(chosen.lens.scaled(1.0 / metres)?));
    Ok(Shot { camera, lens, exposure: shot.exposure.with_held_lens(), description: shot.description })
}

/// The depths of a scene in metres, by pixels of a film.
struct SceneDepths<'a> {
    scene: &'a Scene,
    pose: Pose,
    film: Film,
    metres: f64,
}

impl SceneDepths<'_> {
    /// Depth in metres of what a pixel's centre shows; `None` for the sky.
    fn depth(&self, pixel: Pixel) -> Option<f64> {
        let q = self.film.q_from_pixel(pixel.center());
        let ray = Ray::new(self.pose.position, self.pose.direction_to_world(q.extend(1.0)));
        self.scene.hit(&ray).map(|hit| self.metres * self.pose.point_to_camera(hit.point).z)
    }
}

impl Seen for SceneDepths<'_> {
    fn depth_at(&self, pixel: Pixel) -> anyhow::Result<f64> {
        let depth = self.depth(pixel);
        depth.with_context(|| format!("nothing is seen at pixel {},{}; give --focus-distance", pixel.x, pixel.y))
    }

    fn row(&self, y: i32) -> Option<Vec<(Pixel, f64)>> {
        let inverse = |x| {
            let pixel = Pixel { x, y };
            (pixel, self.depth(pixel).map_or(0.0, f64::recip))
        };
        Some((0..self.film.width() as i32).map(inverse).collect())
    }

    fn say(&self, line: std::fmt::Arguments<'_>) {
        say(line);
    }
}

/// A film of other pixels that shows as much from bottom to top, and as much to the sides as its shape asks for.
fn of_shape(film: Film, width: u32, height: u32) -> anyhow::Result<Film> {
    let (centre, half) = (0.5 * (film.max() + film.min()), 0.5 * (film.max() - film.min()));
    let half = DVec2::new(half.y * f64::from(width) / f64::from(height), half.y);
    Ok(Film::new(centre - half, centre + half, width, height)?)
}
