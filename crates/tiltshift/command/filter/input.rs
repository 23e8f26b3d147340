//! The picture to filter: an RGB-D file, or colour and a depth map of its own.

use std::path::Path;

use anyhow::{Context, anyhow, bail};
use optics::Film;
use rgbd::{
    DepthConvention, DepthMap, DepthSummary, DepthVerdict, Encoding, Frame, Head, Layer, LensAttributes, Loaded,
    MapMeaning, Photo, PhotoFormat, Picture, PixelWindow, Plane, ReadOptions, fill_holes, fit_to_picture, photo_size,
    read_depth_map, read_frame, read_photo, read_picture, survey_file,
};

use super::Source;
use super::job::{Job, Say};
use crate::lens_options::FilmOptions;

/// What was read.
pub(in crate::command) struct Input {
    pub(in crate::command) frame: Frame,
    /// What the file says of lens and sensor.
    pub(in crate::command) lens: LensAttributes,
    /// How it is stored, where it is a photo.
    pub(in crate::command) encoding: Option<Encoding>,
    /// What the depth was taken as, where its flat surfaces were asked.
    pub(in crate::command) told: Option<DepthConvention>,
}

/// Reads colour and depth, and says what was understood.
pub(in crate::command) fn read(job: &Job, options: &Source<'_>, say: Say<'_>) -> anyhow::Result<Input> {
    let (input, max_pixels) = (&job.input, options.read.max_pixels());
    match (PhotoFormat::of_file(input)?, &job.depth) {
        (None, None) => read_rgbd(job, options, say),
        (Some(format), None) => bail!(
            "{input:?} is a {format} picture, which has no depth; name the file of its depth map with --depth FILE"
        ),
        (Some(format), Some(depth)) => {
            let (width, height) = photo_size(input, format)?;
            let film = options.film.settled(&job.lens, width, height, 1.0)?.film(width, height, 1.0)?;
            let Photo { picture, encoding, lens } = read_photo(input, format, max_pixels)?;
            say(format_args!(
                "read {}: {format}, {width}x{height}, linearised by {}",
                input.display(),
                encoding.described
            ));
            if let (Some(mm), Some(fov)) = (lens.focal_length_mm, lens.horizontal_fov_deg) {
                say(format_args!("  its camera notes a lens of {mm} mm and sees {fov:.1} degrees across"));
            }
            let noted = FilmOptions { fov: lens.horizontal_fov_deg.map(f64::from), ..FilmOptions::default() };
            let film = film.or(noted.film(width, height, 1.0)?);
            let head = Head { primaries: encoding.primaries, ..Head::new(picture.window()) };
            let frame = with_map(picture, &head, depth, film.as_ref(), options, say)?;
            Ok(Input { frame, lens, encoding: Some(encoding), told: None })
        }
        (None, Some(depth)) => {
            let read = options.read.options(None, options.film.metres_per_unit);
            let Loaded { value: picture, head, choice, lens, .. } = read_picture(input, &read)?;
            say(format_args!("read {}: {choice}", input.display()));
            let (width, height) = (head.display.width, head.display.height);
            let film = match head.camera {
                Some(camera) => Some(camera.film),
                None => {
                    let aspect = f64::from(head.pixel_aspect);
                    options.film.settled(&job.lens, width, height, aspect)?.film(width, height, aspect)?
                }
            };
            let covered = picture.window().union(&head.display);
            let picture = picture.covering(covered).cropped(head.display);
            let frame = with_map(picture, &head, depth, film.as_ref(), options, say)?;
            Ok(Input { frame, lens, encoding: None, told: None })
        }
    }
}

/// An OpenEXR file that holds both.
fn read_rgbd(job: &Job, options: &Source<'_>, say: Say<'_>) -> anyhow::Result<Input> {
    // Rays need the film before the depth makes sense
    let survey = survey_file(&job.input, options.read.max_pixels())?;
    let (width, height, aspect) = (survey.display.width, survey.display.height, f64::from(survey.pixel_aspect));
    let film = options.film.settled(&job.lens, width, height, aspect)?.film(width, height, aspect)?;
    let mut read = options.read.options(film, options.film.metres_per_unit);
    let typed = options.read.depth_as();
    read.convention = typed.or(job.convention).unwrap_or_default();
    let mut loaded = read_frame(&job.input, &read)?;
    say(format_args!("read {}: {}", job.input.display(), loaded.choice));

    // Ask the flat surfaces, unless the file knows
    let mut told = None;
    if !loaded.choice.is_stated && loaded.head.camera.is_none() {
        let film = film.or(loaded.lens.film(width, height, survey.pixel_aspect));
        let verdict = DepthVerdict::of(&loaded.value.layers()[0].depth, survey.display, film.as_ref());
        check_scale(&job.input, &verdict, options)?;
        told = Some(read.convention);
        match verdict.convention.filter(|&kind| verdict.is_sure() && kind != DepthConvention::Planar) {
            Some(kind) if typed.or(job.convention).is_none() => {
                say(format_args!(
                    "warning: its depth is taken as {verdict}; --depth-as planar takes it as planar depth all the same"
                ));
                loaded = read_frame(&job.input, &ReadOptions { convention: kind, ..read })?;
                told = Some(kind);
            }
            Some(_) => say(format_args!("warning: taken as {}, its depth looks like {verdict}", read.convention)),
            None if typed.is_none() && job.convention.is_none() => say(format_args!("  its depth: {verdict}")),
            None => {}
        }
    }
    let Loaded { value: frame, lens, .. } = loaded;
    Ok(Input { frame, lens, encoding: None, told })
}

/// Fails where depth looks normalised, and nobody says between which distances.
fn check_scale(path: &Path, verdict: &DepthVerdict, options: &Source<'_>) -> anyhow::Result<()> {
    let is_stated = options.read.depth_range().is_some()
        || options.read.depth_as().is_some()
        || options.film.metres_per_unit.is_some();
    if verdict.is_normalised && !is_stated {
        bail!(
            "depth of {path:?} lies from 0 to 1 as if it were normalised; add --depth-range BLACK,WHITE (the distances in \
             metres that 0 and 1 stand for, like 0.5,10; or 10,0.5 where 1 is near), with --depth-as inverse where it is disparity, \
             or --depth-as planar where it is a distance as it stands"
        );
    }
    Ok(())
}

/// A frame of a picture, which covers the display window, and a map of its depth.
fn with_map(
    picture: Picture,
    head: &Head,
    path: &Path,
    film: Option<&Film>,
    options: &Source<'_>,
    say: Say<'_>,
) -> anyhow::Result<Frame> {
    let map = read_depth_map(path, options.read.depth_channel(), options.read.max_pixels())?;
    let display = picture.window();
    check_shape(path, &map, display)?;
    let meaning = meaning(path, &map, film, options)?;
    if meaning.convention == DepthConvention::Ray && film.is_none() {
        bail!(
            "depth of {path:?} as distance along the ray needs the camera's field of view; name --focal-length and \
             --sensor-width, or --fov"
        );
    }

    // Bring it to the picture's pixels, and close holes if asked to
    let (largest, found, window) = (map.largest, map.found.clone(), map.window());
    let planar = map.into_planar(&meaning, film);
    let verdict = DepthVerdict::of(&planar, window, film_of_map(window, film).as_ref());
    if verdict.is_sure() && verdict.convention != Some(DepthConvention::Planar) {
        say(format_args!("warning: taken as {}, the depth looks like {verdict}", meaning.convention));
    }
    let mut depth = fit_to_picture(planar, &picture, largest, &meaning);
    let unknown = depth.values().iter().filter(|depth| depth.is_nan()).count();
    let mut filled = 0;
    if options.read.fills_holes() && unknown > 0 {
        (depth, filled) = fill_holes(depth, &picture);
    }
    tell(path, (window, &found), &meaning, &depth, display, say);
    let share = |pixels: usize| 100.0 * pixels as f64 / display.area() as f64;
    if filled > 0 {
        say(format_args!(
            "  filled holes: {:.1} % of the pixels, from what is known around them (--keep-holes leaves them)",
            share(filled)
        ));
    } else if unknown > 0 {
        say(format_args!(
            "  not known in {:.1} % of the pixels, which take the depth that is known nearest to them, if it is within \
             32 px, and stay sharp farther in",
            share(unknown)
        ));
    }

    let mut frame =
        Frame::new(display, vec![Layer::from_raw_depth(picture, depth)]).with_context(|| format!("{path:?}"))?;
    frame.pixel_aspect = head.pixel_aspect;
    frame.primaries = head.primaries;
    frame.camera = head.camera;
    // A range is typed in metres
    let in_metres = meaning.range.is_some().then_some(1.0);
    frame.metres_per_unit = options.film.metres_per_unit.or(in_metres).or(head.metres_per_unit);
    Ok(frame)
}

/// Fails unless the map has the picture's shape.
fn check_shape(path: &Path, map: &DepthMap, display: PixelWindow) -> anyhow::Result<()> {
    /// Sides that are rounded to whole pixels, or a few columns cropped.
    const SAME: f64 = 0.03;
    let window = map.window();
    let aspect = |window: PixelWindow| f64::from(window.width) / f64::from(window.height);
    if (aspect(window) / aspect(display) - 1.0).abs() <= SAME {
        return Ok(());
    }
    let is_turned = (aspect(window) * aspect(display) - 1.0).abs() <= SAME;
    let remedy = if is_turned {
        "turn it by 90 degrees, as the picture is turned upright by its EXIF orientation or else"
    } else {
        "crop it to what the picture shows"
    };
    let ([a, b], [c, d]) = ([window.width, window.height], [display.width, display.height]);
    bail!("the depth map {path:?} is {a}x{b}, but the picture is {c}x{d}, of another shape; {remedy}")
}

/// The film in pixels of the map.
fn film_of_map(window: PixelWindow, film: Option<&Film>) -> Option<Film> {
    film.and_then(|film| film.resized(window.width, window.height).ok())
}

/// What the map's numbers mean; where that is left open, one sentence asks, and says what its flat surfaces look like.
fn meaning(path: &Path, map: &DepthMap, film: Option<&Film>, options: &Source<'_>) -> anyhow::Result<MapMeaning> {
    let (range, unit) = (options.read.depth_range(), options.film.metres_per_unit);
    let known = map.stored.values().iter().filter(|number| number.is_finite());
    let [least, most] = known.fold([f32::INFINITY, f32::NEG_INFINITY], |[a, b], &x| [a.min(x), b.max(x)]);
    let convention = options.read.depth_as().or(map.is_named.then_some(DepthConvention::Planar));
    let kinds =
        "--depth-as planar (depth along the camera's axis), ray (distance from the lens) or inverse (disparity)";
    let ends = "--depth-range BLACK,WHITE (the distances in metres that black and white stand for, like 0.5,10; or 10,0.5 \
                where white is near)";

    // Whole numbers, and floats from 0 to 1, may be anything
    let is_normalised = map.largest.is_some() || (!map.is_named && least >= 0.0 && (0.99..=1.0).contains(&most));
    let has_scale = range.is_some() || (unit.is_some() && map.largest != Some(255.0));
    match (convention, is_normalised && !has_scale) {
        (None, is_open) => {
            let verdict = DepthVerdict::of(&map.stored, map.window(), film_of_map(map.window(), film).as_ref());
            let looks = verdict.convention.map_or_else(String::new, |_| format!(" (it looks like {verdict})"));
            let ends = if is_open { format!(", and {ends}") } else { String::new() };
            bail!(
                "{path:?} ({}, {least} to {most}) does not say what its numbers mean{looks}; add {kinds}{ends}",
                map.found
            )
        }
        (Some(_), true) if map.largest == Some(65535.0) => bail!(
            "{path:?} holds whole numbers from {least} to {most}; add {ends}, or --metres-per-unit where they count units \
             (0.001 for millimetres)"
        ),
        (Some(_), true) => bail!("{path:?} holds numbers from {least} to {most}; add {ends}"),
        (Some(convention), false) => {
            let is_bad = |end: f32| {
                end == 0.0 && convention == DepthConvention::Inverse
                    || end.is_infinite() && convention != DepthConvention::Inverse
            };
            if let Some(end) = range.and_then(|ends| ends.into_iter().find(|&end| is_bad(end))) {
                return Err(anyhow!("--depth-range has an end at {end}, which {convention} cannot have; give another"));
            }
            Ok(MapMeaning { convention, range, background: options.read.background() })
        }
    }
}

/// Says what was taken as depth.
fn tell(
    path: &Path,
    (window, found_in): (PixelWindow, &str),
    meaning: &MapMeaning,
    depth: &Plane,
    display: PixelWindow,
    say: Say<'_>,
) {
    let range = match meaning.range {
        Some([black, white]) => format!(", black {black} m, white {white} m"),
        None => String::new(),
    };
    let size = match (window.width, window.height) {
        (width, height) if (width, height) == (display.width, display.height) => String::new(),
        (width, height) => format!(", {width}x{height} brought to the picture's size"),
    };
    let found = match DepthSummary::of_depths(depth).range {
        Some([near, far]) => format!("{near:.4} to {far:.4}"),
        None => "nowhere finite".to_owned(),
    };
    say(format_args!(
        "depth from {} ({}{size}), taken as {}{range}: {found}",
        path.display(),
        found_in,
        meaning.convention
    ));
}
