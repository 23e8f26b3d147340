//! Sweeps of the stage's own lens and plane of focus.

use glam::{DVec2, DVec3};
use optics::{Camera, Focus};

use super::sweep::{Input, linear};
use super::{Mode, Stage, Sweep};
use crate::StudyError;

/// The blur, as a share of the picture's width, that tilting sweeps add at the border.
const TILTED_BLUR: f64 = 0.05;

/// Farthest that the lens is turned to either side, degrees.
const LARGEST_TURN_DEG: f64 = 15.0;

/// The plane of focus, tilted by 37 degrees, moves through the lens centre; the aperture is so small that the blur begins
/// at 3 % of the picture's width and is cut only near the centre.
pub(super) fn focus_through_lens<'a>(stage: &'a Stage<'a>, steps: usize) -> Sweep<'a> {
    let begin = 0.2 * stage.focus_distance();
    let normal = DVec3::new(0.0, -0.6, 0.8);
    let radius = 0.03 * f64::from(stage.camera().film.width()) * begin / stage.scale();
    let camera_at = move |at: f64| {
        let pose = stage.camera().pose;
        // A plane of the world, as a user would give it
        let normal = pose.direction_to_world(normal);
        let focus = Focus::from_world_plane(&pose, pose.position + at * begin * normal, normal)?;
        let iris = stage.camera().iris.with_radius(radius)?;
        Ok(Camera { iris, ..stage.focused(focus) })
    };
    Sweep::of_lens(Mode::FocusThroughLens, stage, linear(1.0, -1.0, steps), 1.0, camera_at)
}

/// The vanishing line w(q) = 0 wanders from below the picture to above it.
pub(super) fn vanishing_line<'a>(stage: &'a Stage<'a>, steps: usize) -> Sweep<'a> {
    let half = stage.half_extent().y;
    let slope = slope_for(stage, half, 2.0 * TILTED_BLUR);
    let camera_at = move |at: f64| Ok(stage.focused(Focus::new(DVec3::new(0.0, -slope, slope * at * half))?));
    Sweep::of_lens(Mode::VanishingLine, stage, linear(-1.25, 1.25, steps), 0.0, camera_at)
}

/// Change of w per unit of q that blurs the border, `half` from the axis, by a share of the picture's width.
fn slope_for(stage: &Stage, half: f64, share: f64) -> f64 {
    share * f64::from(stage.camera().film.width()) / (stage.camera().iris.radius() * stage.scale() * half)
}

/// An untilted plane of focus goes to infinity, and comes nearer behind the camera.
pub(super) fn focus_behind_camera<'a>(stage: &'a Stage<'a>, steps: usize) -> Sweep<'a> {
    let nearest = 1.0 / stage.focus_distance();
    let camera_at = move |at: f64| Ok(stage.focused(Focus::new(DVec3::new(0.0, 0.0, at * nearest))?));
    Sweep::of_lens(Mode::FocusBehindCamera, stage, linear(1.0, -1.0, steps), 1.0, camera_at)
}

/// The aperture closes to a pinhole, in steps that get smaller.
pub(super) fn aperture_closing<'a>(stage: &'a Stage<'a>, steps: usize) -> Sweep<'a> {
    let places = linear(1.0, 0.0, steps).into_iter().map(|at| at * at).collect();
    Sweep::of_lens(Mode::ApertureClosing, stage, places, 1.0, move |at| opened(stage, at))
}

/// The aperture opens from half to twice the shot's.
pub(super) fn aperture<'a>(stage: &'a Stage<'a>, steps: usize) -> Sweep<'a> {
    Sweep::of_lens(Mode::Aperture, stage, linear(0.5, 2.0, steps), 2.0, move |at| opened(stage, at))
}

fn opened(stage: &Stage, times: f64) -> Result<Camera, StudyError> {
    let iris = stage.camera().iris;
    Ok(Camera { iris: iris.with_radius(times * iris.radius())?, ..*stage.camera() })
}

/// The lens tilts to both sides of the shot's tilt.
pub(super) fn tilt<'a>(stage: &'a Stage<'a>, steps: usize) -> Sweep<'a> {
    let most = turn_for(stage, stage.half_extent().y);
    Sweep::of_lens(Mode::Tilt, stage, linear(-most, most, steps), 0.0, move |at| turned(stage, at, 0.0))
}

/// The lens swings to both sides of the shot's swing.
pub(super) fn swing<'a>(stage: &'a Stage<'a>, steps: usize) -> Sweep<'a> {
    let most = turn_for(stage, stage.half_extent().x);
    Sweep::of_lens(Mode::Swing, stage, linear(-most, most, steps), 0.0, move |at| turned(stage, 0.0, at))
}

/// The turn in degrees that blurs the border by [`TILTED_BLUR`].
fn turn_for(stage: &Stage, half: f64) -> f64 {
    let sine = slope_for(stage, half, TILTED_BLUR) * stage.lens().focal_length();
    sine.clamp(0.0, 1.0).asin().to_degrees().min(LARGEST_TURN_DEG)
}

fn turned(stage: &Stage, tilt_deg: f64, swing_deg: f64) -> Result<Camera, StudyError> {
    let lens = stage.lens();
    let (tilt, swing) = (lens.tilt() + tilt_deg.to_radians(), lens.swing() + swing_deg.to_radians());
    stage.with_lens(&lens.tilted(tilt, swing)?)
}

/// The window moves by 4 pixels to the right and half as far up.
pub(super) fn shift<'a>(stage: &'a Stage<'a>, steps: usize) -> Sweep<'a> {
    let camera_at = move |at: f64| {
        let film = stage.camera().film.shifted(DVec2::new(at, 0.5 * at) / stage.scale());
        Ok(Camera { film, ..*stage.camera() })
    };
    let sweep = Sweep::of_lens(Mode::Shift, stage, linear(-2.0, 2.0, steps), 0.0, camera_at);
    Sweep { input: Input::Moving, ..sweep }
}

/// The lens is focused on the axis from 0.6 to 1.6 times the shot's distance.
pub(super) fn focus_distance<'a>(stage: &'a Stage<'a>, steps: usize) -> Sweep<'a> {
    let distance = stage.camera().focus.depth(DVec2::ZERO).filter(|depth| depth.is_finite());
    let distance = distance.unwrap_or(stage.focus_distance());
    let camera_at = move |at: f64| stage.with_lens(&stage.lens().focused_at(DVec2::ZERO, at * distance)?);
    Sweep::of_lens(Mode::FocusDistance, stage, linear(0.6, 1.6, steps), 1.0, camera_at)
}
