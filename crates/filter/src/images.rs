//! What mirrors and glass show, blurred by how far away it seems to be.
//!
//! A mirror is a window onto a scene behind it. How much of a pixel's iris sees the window is a matter of the mirror's own
//! surface: of its blur, of what hides it and of what it hides. What is seen through it is blurred as what lies at the depth of
//! the image. So the frame is filtered twice: its surfaces without the light of images, which tells how much of each pixel is
//! missing; and the images by themselves, at their optical depth, as a mean over those pixels that show them. What is missing
//! takes the colour of the second.
//!
//! What is partly transparent shows no image. Behind the rim of a mirror the image goes on with the colour at its rim, since no pixel shows it. An image in a hidden
//! layer, or in what is the smaller part of a silhouette's pixel, is blurred with its surface.

use optics::Camera;
use rgbd::{Frame, Layer, Mask, Picture, PixelWindow, Plane, Progress, Rest};

use crate::{FilterError, Filtered, FrameView, Method, bands::Part};

/// Images whose blur differs less than this from that of their surface stay on it, in pixels of radius.
const LEAST_DIFFERENCE_PX: f64 = 0.25;

/// Pixels of which an image fills less than this leave it to the rest.
const LEAST_SHARE: f32 = 0.02;

/// What pixels of images are scaled by, alpha and all, so that no alpha is cut off where silhouettes are taken apart.
const WEIGHT: f32 = 0.25;

/// What the colour behind the rim counts beside that of pixels that show the image.
const BEHIND_RIM: f32 = 1.0 / 1024.0;

/// Alpha from which on a pixel counts as opaque.
const OPAQUE: f32 = 0.9999;

/// A frame whose images are taken off its surfaces.
pub(crate) struct Images {
    /// The frame without the light of images.
    surfaces: Frame,
    /// The images at their optical depth, elsewhere nearly nothing.
    images: Frame,
    /// The frame, white where there are images and black elsewhere; none if the alpha of `surfaces` tells as much.
    shares: Option<Frame>,
    /// Share of the frame's pixels that show images.
    share: f32,
}

impl Images {
    /// Takes a frame apart; `None` if it shows no images, does not know where they are, or nothing is blurred.
    pub(crate) fn of(frame: &Frame, camera: &Camera, method: &Method) -> Option<Self> {
        let optical = frame.optical_depth()?;
        let layers = method.layers()?;
        let (window, first) = (frame.data(), &frame.layers()[0]);
        let rest = if layers > 1 { frame.rest() } else { None };
        let px = camera.pixels_per_defocus().max_element();
        let shows_image = |x: i32, y: i32| {
            let (image, surface) = (optical.at(x, y), first.depth.at(x, y));
            let difference = px * (1.0 / f64::from(image) - 1.0 / f64::from(surface)).abs();
            let is_opaque = first.color.at(x, y)[3] >= OPAQUE;
            image > 0.0 && first.known.at(x, y) && is_opaque && difference >= LEAST_DIFFERENCE_PX
        };
        let mask = Mask::from_fn(window, |x, y| shows_image(x, y) && filled_by_rest(rest, x, y) <= 1.0 - LEAST_SHARE);
        let count = mask.count();
        if count == 0 {
            return None;
        }

        // Leave on the surfaces what is no image
        let light = |x: i32, y: i32| if mask.at(x, y) { rest_of(rest, x, y) } else { first.color.at(x, y) };
        let surfaces = with_first(frame, Picture::from_fn(window, light));
        let is_opaque = window.pixels().all(|(x, y)| first.color.at(x, y)[3] >= OPAQUE);
        let shares = (!is_opaque).then(|| {
            let black = frame.clone().without_rest().map_color(|[.., a]| [0.0, 0.0, 0.0, a]);
            let share = |x: i32, y: i32| {
                let share = if mask.at(x, y) { 1.0 - filled_by_rest(rest, x, y) } else { 0.0 };
                [share, share, share, first.color.at(x, y)[3]]
            };
            with_first(&black, Picture::from_fn(window, share))
        });

        // Let each pixel without an image go on with the nearest one
        let nearest = nearest(&mask);
        let source = |x: i32, y: i32| place(window, nearest[window.index(x, y)]);
        let image = |x: i32, y: i32| {
            let (u, v) = source(x, y);
            let (whole, rest) = (first.color.at(u, v), rest_of(rest, u, v));
            let own = [0, 1, 2, 3].map(|c| if whole[c] >= 0.0 { (whole[c] - rest[c]).max(0.0) } else { whole[c] });
            let weight = if mask.at(x, y) { WEIGHT } else { WEIGHT * BEHIND_RIM };
            own.map(|c| c * weight)
        };
        let depth = |x: i32, y: i32| {
            let (u, v) = source(x, y);
            optical.at(u, v)
        };
        let layer = Layer {
            color: Picture::from_fn(window, image),
            depth: Plane::from_fn(window, depth),
            known: Mask::filled(window, true),
        };
        let images = Frame::new(frame.display, vec![layer]).ok()?;
        Some(Self { surfaces, images, shares, share: count as f32 / window.area() as f32 })
    }

    /// The frames that are filtered, seen as `view` sees its own.
    pub(crate) fn views<'a>(&'a self, view: &FrameView) -> [FrameView<'a>; 2] {
        [&self.surfaces, &self.images].map(|frame| FrameView::part(frame, view.window()))
    }

    /// Filters surfaces and images with `run`, and joins both.
    pub(crate) fn composed(
        &self,
        view: &FrameView,
        method: &Method,
        progress: &dyn Progress,
        run: impl Fn(&FrameView, &Method, &dyn Progress) -> Result<Filtered, FilterError>,
    ) -> Result<Filtered, FilterError> {
        let (plain, predicts) = method.without_prediction();
        let count = 2 + u64::from(self.shares.is_some()) + u64::from(predicts);
        let part = |index: u64| Part { progress, index, count };
        let [surfaces, images] = self.views(view);
        let surfaces = run(&surfaces, &plain, &part(0))?;
        let images = run(&images, &plain, &part(1))?;
        let share = match &self.shares {
            None => None,
            Some(shares) => {
                let shares = FrameView::part(shares, view.window());
                Some(run(&shares, &plain, &part(2))?.picture)
            }
        };
        // An error is foretold for all light where it is
        let predicted = if predicts { run(view, method, &part(count - 1))?.predicted_error } else { None };

        let window = surfaces.picture.window();
        let join = |x: i32, y: i32| {
            let (mut sum, image) = (surfaces.picture.at(x, y), images.picture.at(x, y));
            let share = share.as_ref().map_or(1.0 - sum[3], |share| share.at(x, y)[0]).clamp(0.0, 1.0);
            if image[3] > 0.0 {
                sum.iter_mut().zip(image).for_each(|(sum, c)| *sum += share * c / image[3]);
            }
            sum
        };
        Ok(Filtered {
            picture: Picture::from_fn(window, join),
            kernel: surfaces.kernel.max(images.kernel),
            kernel_choice: if images.kernel > surfaces.kernel { images.kernel_choice } else { surfaces.kernel_choice },
            largest_radius_px: surfaces.largest_radius_px.max(images.largest_radius_px),
            cut_to_px: surfaces.cut_to_px.or(images.cut_to_px),
            predicted_error: predicted,
            image_share: self.share,
        })
    }
}

/// What of a pixel's colour belongs to another surface; nothing where that is not known.
fn rest_of(rest: Option<Rest>, x: i32, y: i32) -> [f32; 4] {
    rest.and_then(|rest| rest.at(x, y)).map_or([0.0; 4], |rest| rest.rgba)
}

fn filled_by_rest(rest: Option<Rest>, x: i32, y: i32) -> f32 {
    rest_of(rest, x, y)[3]
}

/// The same frame with other colours in its first layer, and without its optical depth.
fn with_first(frame: &Frame, color: Picture) -> Frame {
    let (display, planes) = (frame.display, frame.planes.clone());
    let mut layers = frame.layers().to_vec();
    layers[0].color = color;
    let mut changed = Frame::new(display, layers).expect("layers of a frame");
    changed.planes = planes;
    changed.without_optical_depth()
}

/// The pixel at a row-major index.
fn place(window: PixelWindow, i: u32) -> (i32, i32) {
    ((i % window.width) as i32 + window.x, (i / window.width) as i32 + window.y)
}

/// Index of the nearest pixel of a mask that is not empty, by steps to the eight neighbours; of equals the one that came first.
fn nearest(mask: &Mask) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let window: PixelWindow = mask.window();
    let mut nearest = vec![NONE; window.area()];
    let mut queue: Vec<u32> = (0..window.area() as u32).filter(|&i| mask.bits()[i as usize]).collect();
    queue.iter().for_each(|&i| nearest[i as usize] = i);
    let mut next = 0;
    while let Some(&i) = queue.get(next) {
        next += 1;
        let (x, y) = place(window, i);
        for (u, v) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy))) {
            if window.contains(u, v) {
                let j = window.index(u, v);
                if nearest[j] == NONE {
                    nearest[j] = nearest[i as usize];
                    queue.push(j as u32);
                }
            }
        }
    }
    nearest
}
