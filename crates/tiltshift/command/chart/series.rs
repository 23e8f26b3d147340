//! How the cost of every method grows.

use ::compare::Masks;
use anyhow::{Context, anyhow};
use clap::ValueEnum;
use optics::{Camera, OpticsError};
use study::{Over, Series, Subject, measure};
use trace::Scene;

use super::{Options, rungs, subject_name};
use crate::console::{Bar, print, say};
use crate::failure::Outcome;
use crate::files::{command_line, write_text};

/// What grows in a series.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum Growing {
    /// The picture.
    Size,
    /// The blur.
    Blur,
}

impl Growing {
    /// The cameras of the steps.
    fn cameras(self, camera: &Camera) -> Result<Vec<Camera>, OpticsError> {
        let resized = |divisor: u32| {
            let [width, height] = [camera.film.width(), camera.film.height()].map(|side| (side / divisor).max(1));
            Ok(Camera { film: camera.film.resized(width, height)?, ..*camera })
        };
        let opened = |factor: f64| {
            let iris = camera.iris.with_radius(camera.iris.radius() * factor)?;
            Ok(Camera { iris, ..*camera })
        };
        match self {
            Self::Size => [4, 2, 1].into_iter().map(resized).collect(),
            Self::Blur => [0.5, 1.0, 2.0, 4.0].into_iter().map(opened).collect(),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Size => "size",
            Self::Blur => "blur",
        }
    }
}

/// Runs every method on steps of growing cost.
pub(super) fn run(options: &Options, scene: &Scene, camera: &Camera, growing: Growing) -> Outcome {
    let mut steps = Vec::new();
    for camera in growing.cameras(camera)? {
        let layered = options.quality.layers(scene, &camera)?;
        let frame = &layered.frame;
        let largest = Masks::from_frame(frame, &camera, None)?.largest_coc_radius_px().unwrap_or(0.0);
        let at = match growing {
            Growing::Size => frame.display.area() as f64 * 1e-6,
            Growing::Blur => 2.0 * largest,
        };
        if at <= 0.0 {
            return Err(anyhow!("nothing is blurred in this shot, so that no cost can grow with it").into());
        }
        say(format_args!(
            "{}x{}, largest blur {:.1} px in diameter",
            frame.display.width,
            frame.display.height,
            2.0 * largest
        ));
        let seed = options.quality.other_seed();
        let subject = Subject { scene, camera: &camera, frame, seed, folder: &options.out };
        let rungs = rungs(options, frame.layers().len());
        steps.push((at, measure(&subject, &rungs, options.runs.into(), &Bar::new("run all methods"))?));
    }
    let over = match growing {
        Growing::Size => Over::Megapixels,
        Growing::Blur => Over::BlurDiameterPx,
    };
    let subject = subject_name(&options.scene, options.shot.as_deref());
    let series = Series::new(subject, over, command_line(), &steps);
    print(series.to_csv().trim_end());
    let stem = options.out.join(format!("series_{}", growing.name()));
    let json = serde_json::to_string_pretty(&series.to_json()).context("figures as JSON")?;
    write_text(&stem.with_extension("json"), &(json + "\n"))?;
    write_text(&stem.with_extension("csv"), &series.to_csv())?;
    let svg = stem.with_extension("svg");
    write_text(&svg, &series.to_svg())?;
    say(format_args!("wrote {}", svg.display()));
    Ok(())
}
