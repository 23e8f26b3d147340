//! What a file holds, and what would be made of it.

use std::path::Path;

use crate::attributes::{file_kind, head, lens_attributes, notes};
use crate::choose::{Plan, choose};
use crate::convert::{check_copies, convert_frame, film, fitted, kept_window};
use crate::deep::DeepTally;
use crate::depth_convention::DepthReading;
use crate::encode_exr::FileKind;
use crate::exr_file::ExrFile;
use crate::{
    Choice, DepthSummary, DepthVerdict, Head, LensAttributes, Notes, PixelWindow, Plane, ReadError, ReadOptions,
    SampleKind, Survey,
};

/// What a file holds, and what [`crate::read_frame`] would make of it.
#[derive(Debug)]
pub struct Inspection {
    /// Parts, channels and windows.
    pub survey: Survey,
    /// Windows, colours, unit, and a camera of ours.
    pub head: Head,
    /// What the header says of lens and sensor.
    pub lens: LensAttributes,
    /// The free text of a file of ours.
    pub notes: Notes,
    /// What a file of ours says that it is: `frame`, `picture` or `truth`.
    pub kind: Option<&'static str>,
    /// The frame that would be read, or why there is none.
    pub frame: Result<Understood, ReadError>,
    /// The colour that would be read, where that is all.
    pub picture: Option<Choice>,
    /// Whether red, green and blue of that picture are the same in every pixel, and not one even grey: it may be depth.
    pub picture_is_grey: bool,
    /// What flat surfaces say of it then.
    pub picture_verdict: Option<DepthVerdict>,
}

/// What would be taken as colour and depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Understood {
    /// The channels, and why.
    pub choice: Choice,
    /// How the depth channel stores a number.
    pub depth_kind: SampleKind,
    /// The window of the frame.
    pub window: PixelWindow,
    /// The depths of the first layer.
    pub depth: DepthSummary,
    /// What flat surfaces say of its numbers, as they are stored; none of a file of ours, or a deep one.
    pub verdict: Option<DepthVerdict>,
    /// What a deep part holds.
    pub deep: Option<DeepTally>,
}

/// Inspects a file; all of its flat parts are decoded, to find out whether they are whole.
///
/// A file that cannot be a frame (no depth, names that leave it open, kinds that are not read) is described all the same;
/// one that is damaged, too large or not there is an error.
pub fn inspect(path: &Path, options: &ReadOptions) -> Result<Inspection, ReadError> {
    let file = ExrFile::open(path, options.max_pixels)?;
    let known = head(path, file.meta())?;
    let head = Head { metres_per_unit: options.metres_per_unit.or(known.metres_per_unit), ..known };
    let kind = file_kind(path, file.meta())?.map(|kind| match kind {
        FileKind::Frame { .. } => "frame",
        FileKind::Picture => "picture",
        FileKind::Truth { .. } => "truth",
    });

    // Understand it as a frame, else at least as a picture
    let frame =
        settled(choose(path, file.survey(), options, true).and_then(|plan| understand(&file, plan, &head, options)))?;
    let (mut picture, mut picture_is_grey, mut picture_verdict) = (None, false, None);
    if frame.is_err() {
        let plan = settled(choose(path, file.survey(), options, false))?.ok();
        let wanted = plan.as_ref().filter(|plan| !file.is_deep(plan.color.rgb[0])).map(|plan| plan.color.rgb);
        let planes = settled(file.planes_of_whole_file(&wanted.map(Vec::from).unwrap_or_default()))?;
        if let Ok([r, g, b]) = planes.as_deref() {
            let is_same = |a: &Plane, b: &Plane| a.values().iter().zip(b.values()).all(|(a, b)| a == b || a.is_nan());
            let is_even = r.values().windows(2).all(|pair| pair[0] == pair[1]);
            picture_is_grey = !is_even && is_same(r, g) && is_same(g, b);
            picture_verdict = picture_is_grey.then(|| DepthVerdict::of(r, head.display, options.film.as_ref()));
        }
        picture = plan.map(|plan| plan.choice);
    }
    let header = &file.meta().headers[0];
    Ok(Inspection {
        survey: file.survey().clone(),
        head,
        lens: lens_attributes(header),
        notes: notes(header),
        kind,
        frame,
        picture,
        picture_is_grey,
        picture_verdict,
    })
}

/// Reads what there is to say of the depth of a plan.
fn understand(file: &ExrFile, mut plan: Plan, head: &Head, options: &ReadOptions) -> Result<Understood, ReadError> {
    let at = plan.depth.expect("a frame is planned with depth");
    let window = kept_window(file.window(plan.color.rgb[0]), head.display);
    if file.is_deep(plan.color.rgb[0]) {
        file.planes_of_whole_file(&[])?;
        let converted = convert_frame(file, &plan, head, options)?;
        let layers = converted.frame.layers();
        plan.choice.hidden = (1..layers.len()).map(|i| format!("L{}", i + 1)).collect();
        let depth = DepthSummary::of_planar(&layers[0]);
        return Ok(Understood {
            choice: plan.choice,
            depth_kind: file.kind(at),
            window,
            depth,
            verdict: None,
            deep: converted.deep,
        });
    }
    let film = film(file, head, options)?;
    let film = film.as_ref().map(|film| (film, head.display));
    let wanted = std::iter::once(at).chain(plan.color.alpha).chain(plan.depth_copies.iter().copied());
    let mut planes = file.planes_of_whole_file(&wanted.collect::<Vec<_>>())?;
    let copies = planes.split_off(planes.len() - plan.depth_copies.len());
    check_copies(file, &plan, &planes[0], &copies)?;
    let mut planes = planes.into_iter().map(|plane| fitted(plane, window, 0.0));
    let stored = planes.next().expect("a plane for each channel asked for");
    let alpha = planes.next();
    let alpha = |i: usize| alpha.as_ref().map_or(1.0, |alpha| alpha.values()[i]);
    let reading = DepthReading::of(options, file.kind(at), film).for_all_of(&stored);
    let pixels = window.pixels().zip(stored.values()).enumerate();
    let depth = DepthSummary::of(pixels.map(|(i, (pixel, &z))| (z, reading.planar(z, alpha(i), pixel))));
    if reading.is_turned {
        plan.choice.reason = format!("{}, its negative numbers with their sign turned", plan.choice.reason);
    }

    // Ask the flat parts, where nobody knows
    let mut numbers = stored.clone();
    for ((i, pixel), number) in window.pixels().enumerate().zip(numbers.values_mut()) {
        let is_depth = reading.planar(*number, alpha(i), pixel).is_finite();
        *number = if is_depth { number.abs() } else { f32::NAN };
    }
    let verdict = head.camera.is_none().then(|| DepthVerdict::of(&numbers, head.display, film.map(|(film, _)| film)));
    Ok(Understood { choice: plan.choice, depth_kind: file.kind(at), window, depth, verdict, deep: None })
}

/// An error that says that the file itself is bad ends the inspection; one that says that it does not suit is a finding.
fn settled<T>(result: Result<T, ReadError>) -> Result<Result<T, ReadError>, ReadError> {
    match result {
        Err(
            error @ (ReadError::Io { .. }
            | ReadError::Damaged { .. }
            | ReadError::TooLarge { .. }
            | ReadError::BadAttribute { .. }),
        ) => Err(error),
        result => Ok(result),
    }
}
