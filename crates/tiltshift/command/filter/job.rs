//! One picture from file to file.

use std::path::{Path, PathBuf};

use ::filter::{Filtered, FrameView, Highlights, Method, apply_in_bands, coc_radius_px};
use anyhow::{Context, bail};
use optics::{Camera, Ground, ThinLens};
use rgbd::{DepthConvention, Frame, Head, Progress, could_replace_file};
use serde::Serialize;

use super::aim::{Taken, camera, describe};
use super::input::{Input, read};
use super::result::{Made, check_output, write};
use super::tolerance::{Promise, within};
use super::{Options, Source};
use crate::console::{Bar, Unseen};
use crate::files::{make_folder_of, refuse_overwriting};
use crate::lens_options::LensOptions;

/// What one picture needs besides the options that all share.
#[derive(Debug, Clone)]
pub(in crate::command) struct Job {
    pub(in crate::command) input: PathBuf,
    /// The file of the depth map.
    pub(in crate::command) depth: Option<PathBuf>,
    pub(in crate::command) output: PathBuf,
    pub(in crate::command) png: Option<PathBuf>,
    pub(in crate::command) overlay: Option<PathBuf>,
    pub(in crate::command) lens: LensOptions,
    /// What its depth is taken as where nobody says so; told from its own flat surfaces without.
    pub(in crate::command) convention: Option<DepthConvention>,
    /// The ground in metres, where it is known before the picture is.
    pub(in crate::command) ground: Option<Ground>,
}

/// How progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shown {
    /// As a bar of its own.
    Bar,
    /// Not at all: one of many.
    Nothing,
}

/// What a picture took, for scripts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Report {
    pub(super) input: PathBuf,
    pub(super) output: PathBuf,
    method: &'static str,
    kernel: String,
    largest_coc_diameter_px: f32,
    cut_to_radius_px: Option<f32>,
    focal_length_mm: Option<f64>,
    f_number: Option<f64>,
    tilt_deg: Option<f64>,
    swing_deg: Option<f64>,
    /// On the optical axis; none where the plane of focus is behind the camera there, or at infinity.
    focus_m: Option<f64>,
    filter_seconds: f64,
    /// What is expected of the picture, where a tolerance was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    promise: Option<Promise>,
}

impl Report {
    fn new(job: &Job, method: &Method, filtered: &Filtered, lens: Option<&ThinLens>, filter_seconds: f64) -> Self {
        let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
        Self {
            input: job.input.clone(),
            output: job.output.clone(),
            method: method.name(),
            kernel: filtered.kernel.to_string(),
            largest_coc_diameter_px: 2.0 * filtered.largest_radius_px,
            cut_to_radius_px: filtered.cut_to_px,
            focal_length_mm: lens.map(|lens| lens.focal_length() * 1e3),
            f_number: finite(lens.map(ThinLens::f_number)),
            tilt_deg: lens.map(|lens| lens.tilt().to_degrees()),
            swing_deg: lens.map(|lens| lens.swing().to_degrees()),
            focus_m: finite(lens.and_then(|lens| lens.focus().depth(glam::DVec2::ZERO))),
            filter_seconds,
            promise: None,
        }
    }

    /// What is expected of a picture that is not surely within its tolerance.
    pub(super) fn missed(&self) -> Option<String> {
        self.promise.as_ref().filter(|promise| !promise.is_within).map(Promise::text)
    }
}

/// Takes a line for the user.
pub(in crate::command) type Say<'a> = &'a dyn Fn(std::fmt::Arguments<'_>);

impl Job {
    /// Reads, filters and writes.
    pub(super) fn run(
        &self,
        options: &Options,
        memory_limit: u64,
        shown: Shown,
        say: Say<'_>,
    ) -> anyhow::Result<Report> {
        let highlights = options.highlights.highlights()?;
        let method = options.method.method(options.predicted_error || options.tolerance.is_some());
        self.check(options, &method)?;

        // Read the picture and aim the lens
        let source = Source { film: &options.film, read: &options.read };
        let Input { frame, lens: attributes, encoding, .. } = read(self, &source, say)?;
        let display = frame.display;
        let frame = frame.covering(display);
        let Taken { camera, lens } = camera(self, &source, &frame, &attributes, say)?;
        describe(&camera, lens.as_ref(), options.verbose, say);
        let camera = opened(&camera, options.method.blur_scale)?;

        let frame = if options.method.no_optical_depth { frame.without_optical_depth() } else { frame };

        // Give highlights back what clipping took
        let frame = match highlights {
            Some(highlights) => recover(&highlights, frame, say),
            None => frame,
        };

        // Filter it
        let started = std::time::Instant::now();
        let filter = |method: &Method| {
            let progress: Box<dyn Progress> = match shown {
                Shown::Bar => Box::new(Bar::new(format!("filter ({})", method.name()))),
                Shown::Nothing => Box::new(Unseen),
            };
            let view = FrameView::whole(&frame);
            Ok(apply_in_bands(&view, &camera, method, display, memory_limit, progress.as_ref())?)
        };
        let (method, filtered, promise) = match options.tolerance {
            None => (method, filter(&method)?, None),
            Some(tolerance) => {
                let (method, filtered, promise) = within(method, tolerance, filter, say)?;
                (method, filtered, Some(promise))
            }
        };
        let seconds = started.elapsed().as_secs_f64();
        tell(&filtered, &method, seconds, options.verbose, say);
        if let Some(promise) = promise.as_ref().filter(|promise| promise.is_within) {
            say(format_args!("  {}", promise.text()));
        }
        let report = Report { promise, ..Report::new(self, &method, &filtered, lens.as_ref(), seconds) };

        // Write what came out; the frame makes room for the file
        let coc = (options.coc || self.overlay.is_some())
            .then(|| coc_radius_px(&FrameView::whole(&frame), &camera).cropped(display));
        let head = Head::from(&frame);
        drop(frame);
        write(
            self,
            options,
            Made { head, camera: &camera, lens: lens.as_ref(), encoding, filtered, coc, method },
            say,
        )?;
        Ok(report)
    }

    /// The files that come out.
    pub(super) fn outputs(&self) -> impl Iterator<Item = &Path> {
        [Some(self.output.as_path()), self.png.as_deref(), self.overlay.as_deref()].into_iter().flatten()
    }

    /// Finds out before any work what cannot be.
    fn check(&self, options: &Options, method: &Method) -> anyhow::Result<()> {
        check_output(self, options)?;
        let outputs: Vec<&Path> = self.outputs().collect();
        let inputs: Vec<&Path> = [Some(self.input.as_path()), self.depth.as_deref()].into_iter().flatten().collect();
        refuse_overwriting(&inputs, &outputs)?;
        for output in outputs {
            make_folder_of(output)?;
            could_replace_file(output).with_context(|| format!("cannot write {output:?}"))?;
        }
        let wants_error =
            [("--predicted-error", options.predicted_error), ("--tolerance", options.tolerance.is_some())];
        if let (Some((option, _)), Method::Pinhole | Method::OwnCoc(_)) =
            (wants_error.into_iter().find(|(_, wanted)| *wanted), method)
        {
            bail!("{option} is known for gather, merged and lens-rays only, not for {}", method.name());
        }
        Ok(())
    }
}

/// The camera with its iris opened or closed.
fn opened(camera: &Camera, scale: f64) -> anyhow::Result<Camera> {
    if !(scale >= 0.0 && scale.is_finite()) {
        bail!("--blur-scale is {scale}; it must be 0 or positive");
    }
    let iris = camera.iris.with_radius(camera.iris.radius() * scale)?;
    Ok(Camera { iris, ..*camera })
}

/// Raises highlights and says how many there were.
fn recover(highlights: &Highlights, frame: Frame, say: Say<'_>) -> Frame {
    let color = &frame.layers()[0].color;
    let raised = color.window().pixels().filter(|&(x, y)| {
        let was = color.at(x, y);
        highlights.recovered(was).iter().zip(was).any(|(&now, was)| now > was)
    });
    let share = 100.0 * raised.count() as f64 / frame.data().area() as f64;
    say(format_args!("highlights raised in {share:.2} % of the pixels"));
    highlights.recover(frame)
}

/// Says what was done.
fn tell(filtered: &Filtered, method: &Method, seconds: f64, verbose: bool, say: Say<'_>) {
    say(format_args!(
        "method {}; largest circle of confusion {:.1} px in diameter; {seconds:.2} s",
        method.name(),
        2.0 * filtered.largest_radius_px
    ));
    if filtered.image_share > 0.0 {
        say(format_args!(
            "  what mirrors and glass show in {:.1} % of the pixels is blurred by its optical depth (--no-optical-depth: by their surface)",
            100.0 * filtered.image_share
        ));
    }
    if let Some(limit) = filtered.cut_to_px {
        say(format_args!("  cut to a radius of {limit} px; --max-radius sets the limit"));
    }
    if let (Some(choice), true) = (filtered.kernel_choice, verbose) {
        say(format_args!("  {choice}"));
    }
}
