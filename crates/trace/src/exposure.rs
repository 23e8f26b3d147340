//! The time during which a picture is taken.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec2, DVec3};
use optics::{Camera, Film, Focus, Pose};

/// Where a camera stands and looks at some time of an exposure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moment {
    pub(crate) pose: Pose,
    /// Left, bottom, right and top of the window.
    pub(crate) window: [DVec2; 2],
    /// The plane of focus.
    pub(crate) w: DVec3,
}

impl Moment {
    pub(crate) fn of(camera: &Camera) -> Self {
        Self { pose: camera.pose, window: [camera.film.min(), camera.film.max()], w: camera.focus.w() }
    }
}

/// When the shutter opens and closes, in frames, and how the camera moves meanwhile.
///
/// A picture's camera is the one in the middle of its exposure; depth and layers stand there too.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Exposure {
    times: [f64; 2],
    /// The camera at evenly spaced times; nothing where it stands still.
    track: Option<Arc<[Moment]>>,
    /// Whether the track tells the pose only, and window and focus stay.
    has_held_lens: bool,
}

impl Exposure {
    /// Longest exposure in frames.
    pub(crate) const LONGEST: f64 = 1e4;

    /// One in which the camera stands still, from `open` to `close` in frames; `None` unless both are finite, in this order,
    /// and not more than 10,000 frames apart.
    #[must_use]
    pub fn new(open: f64, close: f64) -> Option<Self> {
        let is_one = open.is_finite() && (0.0..=Self::LONGEST).contains(&(close - open));
        is_one.then(|| Self { times: [open, close], ..Self::default() })
    }

    /// The same with a camera that goes through cameras at evenly spaced times, the first as the shutter opens and the last as
    /// it closes; between two it turns evenly. The iris stays as it is in the middle.
    #[must_use]
    pub fn with_cameras(self, cameras: &[Camera]) -> Self {
        let track: Vec<Moment> = cameras.iter().map(Moment::of).collect();
        let moves = track.iter().any(|moment| *moment != track[0]);
        Self { track: moves.then(|| track.into()), ..self }
    }

    /// When it opens and closes, in frames.
    #[must_use]
    pub fn times(&self) -> [f64; 2] {
        self.times
    }

    /// Its middle in frames.
    #[must_use]
    pub fn middle(&self) -> f64 {
        0.5 * (self.times[0] + self.times[1])
    }

    /// Whether the camera moves.
    #[must_use]
    pub fn moves_camera(&self) -> bool {
        self.track.is_some()
    }

    /// The same, all at its middle.
    #[must_use]
    pub fn stopped(&self) -> Self {
        Self { times: [self.middle(); 2], ..Self::default() }
    }

    /// The same with a lens and a film that stay as those of the picture's camera: only its place and its direction change.
    #[must_use]
    pub fn with_held_lens(self) -> Self {
        Self { has_held_lens: true, ..self }
    }

    /// A time in frames, from one in [0, 1] from opening to closing.
    pub(crate) fn frame(&self, time: f32) -> f64 {
        self.times[0] + f64::from(time) * (self.times[1] - self.times[0])
    }

    /// The camera at a time in [0, 1], from the one in the middle.
    pub(crate) fn camera(&self, middle: &Camera, time: f32) -> Camera {
        let Some(track) = &self.track else { return *middle };
        let at = |time: f64| {
            let place = time * (track.len() - 1) as f64;
            let before = (place as usize).min(track.len().saturating_sub(2));
            let after = (before + 1).min(track.len() - 1);
            between(&track[before], &track[after], place - before as f64)
        };
        let now = at(f64::from(time));
        let mut camera = Camera { pose: now.pose, ..*middle };
        if !self.has_held_lens {
            // What the picture's own camera does otherwise than the track stays
            let usual = at(0.5);
            let film = middle.film;
            let [min, max] =
                [film.min() + (now.window[0] - usual.window[0]), film.max() + (now.window[1] - usual.window[1])];
            camera.film = Film::new(min, max, film.width(), film.height()).unwrap_or(film);
            camera.focus = Focus::new(middle.focus.w() + (now.w - usual.w)).unwrap_or(middle.focus);
        }
        camera
    }
}

/// Between two moments: places and numbers straight, directions by an even turn.
fn between(a: &Moment, b: &Moment, share: f64) -> Moment {
    if a == b {
        return *a;
    }
    // Camera axes are left-handed; what turns them is a rotation all the same
    let axes = |pose: &Pose| DQuat::from_mat3(&DMat3::from_cols(pose.right, pose.up, -pose.forward));
    let turned = DMat3::from_quat(axes(&a.pose).slerp(axes(&b.pose), share));
    let pose = Pose {
        position: a.pose.position.lerp(b.pose.position, share),
        right: turned.x_axis,
        up: turned.y_axis,
        forward: -turned.z_axis,
    };
    let window = [0, 1].map(|corner| a.window[corner].lerp(b.window[corner], share));
    Moment { pose, window, w: a.w.lerp(b.w, share) }
}

#[cfg(test)]
mod tests {
    use optics::Iris;

    use super::*;

    fn looking(turn: f64) -> Camera {
        let target = DVec3::new(turn.sin(), 0.0, -turn.cos());
        Camera {
            pose: Pose::look_at(DVec3::ZERO, target, DVec3::Y).unwrap(),
            film: Film::from_fov(1.0, 8, 8).unwrap(),
            focus: Focus::at_depth(1.0 + turn).unwrap(),
            iris: Iris::pinhole(),
        }
    }

    #[test]
    fn a_camera_turns_evenly_between_moments() {
        let exposure = Exposure::new(0.0, 1.0).unwrap().with_cameras(&[looking(0.0), looking(0.4), looking(0.8)]);
        for i in 0..=16 {
            let time = i as f32 / 16.0;
            let [found, wanted] = [exposure.camera(&looking(0.4), time), looking(0.8 * f64::from(time))];
            assert!(found.pose.forward.distance(wanted.pose.forward) < 1e-12, "{time}");
            assert!(found.pose.right.cross(found.pose.up).distance(-found.pose.forward) < 1e-12);
        }
        // A lens that was chosen otherwise keeps its plane of focus
        let held = exposure.with_held_lens().camera(&looking(0.4), 1.0);
        assert_eq!(held.focus, looking(0.4).focus);
    }

    #[test]
    fn one_that_does_not_move_is_none() {
        let exposure = Exposure::new(0.0, 1.0).unwrap().with_cameras(&[looking(0.3); 5]);
        assert!(!exposure.moves_camera());
        assert!(Exposure::new(1.0, 0.0).is_none() && Exposure::new(f64::NAN, 0.0).is_none());
        assert!(Exposure::new(0.0, f64::INFINITY).is_none() && Exposure::new(0.0, 2e4).is_none());
    }
}
