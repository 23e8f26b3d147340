//! The chosen channels of another program's file as a frame or a picture.

use crate::choose::Plan;
use crate::choose_color::ColorGroup;
use crate::depth_convention::planar_depth;
use crate::exr_file::ExrFile;
use crate::survey::ChannelIndex;
use crate::{DepthConvention, Frame, Head, Layer, Mask, Picture, PixelWindow, Plane, ReadError, ReadOptions};

/// A frame in the window of its colour; where depth has no pixels there it is unknown.
pub(crate) fn convert_frame(
    file: &ExrFile,
    plan: &Plan,
    head: &Head,
    options: &ReadOptions,
) -> Result<Frame, ReadError> {
    let path = file.path();
    let film = head.camera.as_ref().map(|camera| camera.film).or(options.film);
    if options.convention == DepthConvention::Ray && film.is_none() {
        return Err(ReadError::NeedsCamera { path: path.into() });
    }
    let place = film.as_ref().map(|film| (film, head.display));

    // Read all at once: each part is decoded once only
    let nearest = plan.depth.map(|depth| (&plan.color, depth));
    let hidden = plan.hidden.iter().map(|(group, depth)| (group, *depth));
    let sources: Vec<(&ColorGroup, ChannelIndex)> = nearest.into_iter().chain(hidden).collect();
    let wanted: Vec<ChannelIndex> =
        sources.iter().flat_map(|(group, depth)| group.channels().chain(std::iter::once(*depth))).collect();
    let mut planes = file.planes(&wanted)?.into_iter();

    // Bring each layer to the window of the first one's colour
    let window = file.window(plan.color.rgb[0]);
    let mut layers = Vec::with_capacity(sources.len());
    for (i, (group, depth)) in sources.iter().enumerate() {
        let mut next = || fitted(planes.next().expect("a plane for each channel asked for"), window, 0.0);
        let rgb = [next(), next(), next()];
        let alpha = group.alpha.is_some().then(&mut next);
        let raw = next();
        let layer = layer_from(rgb, alpha, raw, i > 0, |raw, alpha| {
            planar_depth(raw, alpha, options.convention, file.kind(*depth), place)
        });
        layers.push(layer);
    }
    assemble(file, head, layers)
}

/// The chosen colour alone; opaque where the file has no alpha.
pub(crate) fn convert_picture(file: &ExrFile, plan: &Plan) -> Result<Picture, ReadError> {
    let window = file.window(plan.color.rgb[0]);
    let wanted: Vec<ChannelIndex> = plan.color.channels().collect();
    let planes = file.planes(&wanted)?.into_iter().chain(std::iter::once(Plane::filled(window, 1.0)));
    let planes: Vec<Plane> = planes.take(4).map(|plane| fitted(plane, window, 0.0)).collect();
    Ok(picture_from(planes))
}

/// A layer from colour, alpha where there is one, and depth as stored.
///
/// Without alpha the first layer is opaque, and a hidden one where its depth is known: elsewhere it is absent.
fn layer_from(
    rgb: [Plane; 3],
    alpha: Option<Plane>,
    raw: Plane,
    hidden: bool,
    planar: impl Fn(&Plane, &Plane) -> Plane,
) -> Layer {
    let window = raw.window();
    let has_alpha = alpha.is_some();
    let alpha = alpha.unwrap_or_else(|| Plane::filled(window, 1.0));
    let depth = planar(&raw, &alpha);
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

/// A frame of these layers with the head's windows, colours, unit and camera.
pub(crate) fn assemble(file: &ExrFile, head: &Head, layers: Vec<Layer>) -> Result<Frame, ReadError> {
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
fn fitted(plane: Plane, window: PixelWindow, outside: f32) -> Plane {
    if plane.window() == window {
        return plane;
    }
    Plane::from_fn(window, |x, y| plane.get(x, y).unwrap_or(outside))
}
