//! The chosen channels of another program's file as a frame or a picture.

use optics::Film;

use crate::attributes::lens_attributes;
use crate::choose::Plan;
use crate::choose_color::ColorGroup;
use crate::deep::{DeepFrame, read_deep};
use crate::depth_convention::DepthReading;
use crate::exr_file::ExrFile;
use crate::survey::ChannelIndex;
use crate::{
    DeepTally, DepthConvention, Frame, Head, Layer, Mask, Picture, PixelWindow, Plane, ReadError, ReadOptions,
};

/// A frame in the window of its colour; where depth has no pixels there it is unknown.
pub(crate) fn convert_frame(
    file: &ExrFile,
    plan: &Plan,
    head: &Head,
    options: &ReadOptions,
) -> Result<Converted, ReadError> {
    let depth = plan.depth.expect("a frame is planned with depth");
    let film = film(file, head, options)?;
    let reading = |at| DepthReading::of(options, file.kind(at), film.as_ref().map(|film| (film, head.display)));
    let window = kept_window(file.window(plan.color.rgb[0]), head.display);
    if file.is_deep(plan.color.rgb[0]) {
        let DeepFrame { layers, tally } = read_deep(file, plan, window, reading(depth))?;
        return Ok(Converted {
            frame: assemble(file, head, layers, options.max_pixels)?,
            deep: Some(tally),
            is_turned: false,
        });
    }

    // Read all at once: each part is decoded once only
    let hidden = plan.hidden.iter().map(|(group, depth)| (group, *depth));
    let sources: Vec<(&ColorGroup, ChannelIndex)> = std::iter::once((&plan.color, depth)).chain(hidden).collect();
    let wanted: Vec<ChannelIndex> = sources
        .iter()
        .flat_map(|(group, depth)| group.channels().chain(std::iter::once(*depth)))
        .chain(plan.depth_copies.iter().copied())
        .collect();
    let mut planes = file.planes(&wanted)?;
    let copies = planes.split_off(wanted.len() - plan.depth_copies.len());
    check_copies(file, plan, &planes[plan.color.channels().count()], &copies)?;
    drop(copies);
    let mut planes = planes.into_iter();

    // Bring each layer to the window of the first one's colour
    let mut layers = Vec::with_capacity(sources.len());
    let mut is_turned = false;
    for (i, (group, depth)) in sources.iter().enumerate() {
        let mut next = || fitted(planes.next().expect("a plane for each channel asked for"), window, 0.0);
        let rgb = [next(), next(), next()];
        let alpha = group.alpha.is_some().then(&mut next);
        let raw = next();
        let reading = reading(*depth).for_all_of(&raw);
        is_turned |= reading.is_turned;
        layers.push(layer_from(rgb, alpha, raw, i > 0, |raw, alpha| reading.planar_plane(raw, Some(alpha))));
    }
    Ok(Converted { frame: assemble(file, head, layers, options.max_pixels)?, deep: None, is_turned })
}

/// A frame, and what its deep part held where it is of one.
pub(crate) struct Converted {
    pub(crate) frame: Frame,
    pub(crate) deep: Option<DeepTally>,
    /// Whether its depths were negative.
    pub(crate) is_turned: bool,
}

/// The chosen colour alone, flattened where it is deep; opaque where the file has no alpha.
pub(crate) fn convert_picture(
    file: &ExrFile,
    plan: &Plan,
    head: &Head,
    options: &ReadOptions,
) -> Result<Picture, ReadError> {
    if file.is_deep(plan.color.rgb[0]) {
        let layer = convert_frame(file, plan, head, options)?.frame.into_layers().swap_remove(0);
        return Ok(layer.color);
    }
    let window = file.window(plan.color.rgb[0]);
    let wanted: Vec<ChannelIndex> = plan.color.channels().collect();
    let mut planes = file.planes(&wanted)?;
    if plan.color.alpha.is_none() {
        planes.push(Plane::filled(window, 1.0));
    }
    let window = kept_window(window, head.display);
    Ok(picture_from(planes.into_iter().map(|plane| fitted(plane, window, 0.0)).collect()))
}

/// The film that depths along the ray need, of the file's own camera, the options, or what the header says of the lens; an error
/// where they need one and there is none.
pub(crate) fn film(file: &ExrFile, head: &Head, options: &ReadOptions) -> Result<Option<Film>, ReadError> {
    let display = head.display;
    let noted = || lens_attributes(&file.meta().headers[0]).film(display.width, display.height, head.pixel_aspect);
    let film = head.camera.map(|camera| camera.film).or(options.film).or_else(noted);
    if options.convention == DepthConvention::Ray && film.is_none() {
        return Err(ReadError::NeedsCamera { path: file.path().into() });
    }
    Ok(film)
}

/// What is kept of a data window: up to one picture beside the picture, which is more than any blur reaches. A window that
/// lies farther out is empty for the picture: its top left pixel stands for it.
pub(crate) fn kept_window(data: PixelWindow, display: PixelWindow) -> PixelWindow {
    let kept = data.intersection(&display.grown(display.width, display.height));
    if kept.is_empty() { PixelWindow { width: 1, height: 1, ..display } } else { kept }
}

/// An error unless the channels that should repeat the depth do.
pub(crate) fn check_copies(file: &ExrFile, plan: &Plan, depth: &Plane, copies: &[Plane]) -> Result<(), ReadError> {
    let same = |copy: &Plane| copy.values().iter().zip(depth.values()).all(|(a, b)| a.to_bits() == b.to_bits());
    if copies.iter().all(same) {
        return Ok(());
    }
    let labels = plan.depth.iter().chain(&plan.depth_copies).map(|&at| file.survey().label(at));
    Err(ReadError::Ambiguous {
        path: file.path().into(),
        what: "depth",
        candidates: labels.collect::<Vec<_>>().join(", "),
        option: "--depth",
    })
}

/// A layer from colour, alpha where there is one, and depth as stored.
///
/// Without alpha the first layer is opaque, and a hidden one where its depth is known: elsewhere it is absent.
fn layer_from(
    rgb: [Plane; 3],
    alpha: Option<Plane>,
    raw: Plane,
    hidden: bool,
    planar: impl Fn(Plane, &Plane) -> Plane,
) -> Layer {
    let window = raw.window();
    let has_alpha = alpha.is_some();
    let alpha = alpha.unwrap_or_else(|| Plane::filled(window, 1.0));
    let depth = planar(raw, &alpha);
    let absent = Mask::from_fn(window, |x, y| hidden && !has_alpha && depth.at(x, y).is_nan());
    let mut planes: Vec<Plane> = rgb.into_iter().chain(std::iter::once(alpha)).collect();
    for plane in &mut planes {
        for (value, &absent) in plane.values_mut().iter_mut().zip(absent.bits()) {
            if absent {
                *value = 0.0;
            }
        }
    }
    Layer::from_raw_depth(picture_from(planes), depth)
}

/// A frame of these layers with the head's windows, colours, unit and camera; what it needs to cover the picture and the
/// data is at most `max_pixels`.
pub(crate) fn assemble(file: &ExrFile, head: &Head, layers: Vec<Layer>, max_pixels: u64) -> Result<Frame, ReadError> {
    let covered = layers.first().map_or(head.display, |layer| layer.window().union(&head.display));
    let pixels = u64::from(covered.width) * u64::from(covered.height);
    if pixels > max_pixels {
        let what = "display and data window together".into();
        return Err(ReadError::TooLarge { path: file.path().into(), what, pixels, limit: max_pixels });
    }
    let made = Frame::new(head.display, layers);
    let mut frame = made.map_err(|source| ReadError::Frame { path: file.path().into(), source })?;
    frame.pixel_aspect = head.pixel_aspect;
    frame.primaries = head.primaries;
    frame.metres_per_unit = head.metres_per_unit;
    frame.camera = head.camera;
    Ok(frame)
}

/// A picture from red, green, blue and alpha, which must have one window.
pub(crate) fn picture_from(planes: Vec<Plane>) -> Picture {
    let planes: [Plane; 4] = planes.try_into().expect("four channels make a picture");
    Picture::from_planes(planes).expect("the channels of a picture have one window")
}

/// The plane in another window, with `outside` where it has no pixels.
pub(crate) fn fitted(plane: Plane, window: PixelWindow, outside: f32) -> Plane {
    if plane.window() == window {
        return plane;
    }
    Plane::from_fn(window, |x, y| plane.get(x, y).unwrap_or(outside))
}
