//! A shot at any time: where its camera stands, and how long its shutter is open.

use std::ops::RangeInclusive;

use super::animation::Animation;
use super::error::Fault;
use super::shot::{Shot, ShotTables};
use super::spec::ShutterSpec;
use crate::Exposure;

/// Moments between which a camera moves evenly in a longer exposure: what it turns and swerves meanwhile is met within some
/// 1e-5 of its way.
const STEPS: u32 = 128;
/// The same where it only has to be known that there are cameras at all.
pub(super) const FEW_STEPS: u32 = 2;

/// What a file says of a shot.
#[derive(Debug, Clone)]
pub(super) struct Take {
    pub(super) description: String,
    pub(super) tables: ShotTables,
    pub(super) animation: Option<Animation>,
    pub(super) metres_per_unit: Option<f64>,
    /// What a user wants of all shots.
    pub(super) shutter: Option<f64>,
}

impl Take {
    /// The frames that its keys are for.
    pub(super) fn frames(&self) -> Option<RangeInclusive<i64>> {
        self.animation.as_ref().map(Animation::frames)
    }

    /// As nobody says when: its first frame, or the time that its camera says.
    pub(super) fn still(&self) -> Result<Shot, Fault> {
        let frame = match self.frames() {
            Some(frames) => *frames.start() as f64,
            None => self.tables.camera.frame.unwrap_or(0.0),
        };
        self.at(frame)
    }

    /// In a frame.
    pub(super) fn at(&self, frame: f64) -> Result<Shot, Fault> {
        self.in_steps(frame, STEPS)
    }

    pub(super) fn in_steps(&self, frame: f64, steps: u32) -> Result<Shot, Fault> {
        let shutter = self.tables_at(frame)?.camera.shutter.unwrap_or_default();
        let [open, close] = self.shutter.map_or(shutter, ShutterSpec::centred).0;
        let Some(exposure) = Exposure::new(frame + open, frame + close) else {
            let longest = Exposure::LONGEST;
            return Fault::says(format!(
                "a shutter opens before it closes, at most {longest} frames later; frame and both times must be finite"
            ));
        };
        let shot = self.tables_at(exposure.middle())?.resolve(&self.description, self.metres_per_unit)?;
        if self.animation.is_none() || close <= open {
            return Ok(Shot { exposure, ..shot });
        }
        let camera = |step: u32| -> Result<_, Fault> {
            let tables = self.tables_at(exposure.frame(step as f32 / steps as f32))?;
            Ok(tables.resolve("", self.metres_per_unit)?.camera)
        };
        let cameras = (0..=steps).map(camera).collect::<Result<Vec<_>, _>>()?;
        Ok(Shot { exposure: exposure.with_cameras(&cameras), ..shot })
    }

    fn tables_at(&self, frame: f64) -> Result<ShotTables, Fault> {
        match &self.animation {
            Some(animation) => animation.over(&self.tables, frame),
            None => Ok(self.tables.clone()),
        }
    }
}
