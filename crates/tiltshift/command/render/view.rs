//! What is seen of a scene, where the command line says it otherwise.

use anyhow::{Context, anyhow};
use glam::DVec2;
use optics::{Camera, Film};
use trace::{Ray, Scene, Shot};

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
    if let Some(other) = film_options.film(film.width(), film.height(), 1.0)? {
        shot.camera.film = other;
        shot.lens = None;
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
    let LensOptions { focus_distance, focus_pixel, focus_points, focus_plane, .. } = &lens_options;
    let is_focused =
        focus_distance.is_some() || focus_pixel.is_some() || focus_points.is_some() || focus_plane.is_some();
    if !is_focused {
        lens_options.focus_pixel = Some(Pixel { x: (film.width() / 2) as i32, y: (film.height() / 2) as i32 });
    }
    let pose = shot.camera.pose;
    let depth_at = |pixel: Pixel| {
        let q = film.q_from_pixel(pixel.center());
        let ray = Ray::new(pose.position, pose.direction_to_world(q.extend(1.0)));
        let hit = scene.hit(&ray);
        let hit =
            hit.with_context(|| format!("nothing is seen at pixel {},{}; give --focus-distance", pixel.x, pixel.y))?;
        Ok(metres * pose.point_to_camera(hit.point).z)
    };
    let focal_length_mm = Some(focal_length_mm.unwrap_or(from_film));
    let chosen = lens_options.camera(pose, film, focal_length_mm, metres, depth_at)?;
    Ok(Shot { camera: Camera { film, ..chosen.camera }, lens: Some(chosen.lens.scaled(1.0 / metres)?), ..shot })
}

/// A film of other pixels that shows as much from bottom to top, and as much to the sides as its shape asks for.
fn of_shape(film: Film, width: u32, height: u32) -> anyhow::Result<Film> {
    let (centre, half) = (0.5 * (film.max() + film.min()), 0.5 * (film.max() - film.min()));
    let half = DVec2::new(half.y * f64::from(width) / f64::from(height), half.y);
    Ok(Film::new(centre - half, centre + half, width, height)?)
}
