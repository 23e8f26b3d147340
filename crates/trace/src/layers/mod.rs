//! What a filter needs: colour and depth in layers, with what lies hidden and what lies outside the picture.

mod candidates;
mod facing;
mod hidden;
mod lens_points;
mod margin;
mod optical;
mod part;
mod rest;
mod walk;

pub use optical::optical_depth;

use optics::Camera;
use rayon::prelude::*;
use rgbd::{Cancelled, Frame, Layer, Mask, Picture, PixelWindow, Plane, Progress};

use crate::layers::hidden::{Behind, Centres};
use crate::layers::part::Surface;
use crate::layers::rest::Inside;
use crate::layers::walk::{Walk, pinhole_ray};
use crate::{RenderError, Scene, render};

/// How far the data window reaches beyond the display window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Margin {
    /// As far as rays through the lens of the outermost pixels go, up to a share of the picture's width on each side.
    Needed {
        /// The largest margin over the width, 0 or more.
        cap: f64,
    },
    /// This many pixels on each side.
    Pixels(u32),
}

/// What to write into an RGB-D frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerSettings {
    /// Number of layers, at least 1; all after the first are hidden ones.
    pub count: usize,
    /// The margin around the picture.
    pub margin: Margin,
    /// Samples per pixel of the first layer's colour, and of the hidden ones' where a surface ends.
    pub color_samples: u32,
    /// Seed of these samples.
    pub seed: u64,
}

impl Default for LayerSettings {
    /// Two layers, the margin that is needed up to a quarter of the width, 64 samples.
    fn default() -> Self {
        Self { count: 2, margin: Margin::Needed { cap: 0.25 }, color_samples: 64, seed: 1 }
    }
}

/// An RGB-D frame, and whether its margin is all that the lens needs.
#[derive(Debug, Clone, PartialEq)]
pub struct LayeredFrame {
    /// The frame; its camera is the one with the lens.
    pub frame: Frame,
    /// Columns and rows on each side that rays through the lens reach.
    pub needed_margin: [u32; 2],
    /// Columns and rows on each side that the data window has.
    pub margin: [u32; 2],
}

impl LayeredFrame {
    /// Whether rays through the lens leave the data window.
    #[must_use]
    pub fn is_capped(&self) -> bool {
        self.margin[0] < self.needed_margin[0] || self.margin[1] < self.needed_margin[1]
    }
}

/// Makes the RGB-D frame of a view.
///
/// The first layer holds the pinhole picture, its colour the average over the pixel, its depth that of the first hit at
/// the pixel's centre (+inf where there is none). What of the colour belongs to other surfaces than that one is the frame's
/// [rest](Frame::rest), seen by the same samples (unless there is one layer only). Each further layer holds the next surface
/// behind it in the pixel that at least one of 48 points of the camera's own iris sees, or nothing, alpha 0 and depth unknown.
/// Its alpha is the share of the pixel's samples that meet it, whether as the first on their way or behind others: 1 where it
/// goes on through all of the pixel, less where it ends. At the rim of what lens points see of it, only the share of up to 8 of its points
/// that they do see counts. Its colour is the premultiplied average of those samples (of 64 where no surface ends), its depth that at the pixel's
/// centre, continued there if the centre misses it. If a pixel has more surfaces than there are layers, the last
/// layer holds the one that covers the most of what is left. Back faces, and so the insides of solids, are left out.
/// Where mirrors or glass show images the frame has their [`optical_depth`] too. Every ray is
/// traced; no blur size is computed. Where things or the camera move, all layers, colours too, are those of the exposure's middle.
pub fn layers(
    scene: &Scene,
    camera: &Camera,
    settings: &LayerSettings,
    progress: &dyn Progress,
) -> Result<LayeredFrame, RenderError> {
    let scene = &scene.stopped();
    // Find out how much is needed around the picture
    let display = PixelWindow::of_size(camera.film.width(), camera.film.height());
    let needed_margin = margin::needed(scene, camera);
    let margin = match settings.margin {
        Margin::Pixels(pixels) => [pixels; 2],
        Margin::Needed { cap } => {
            let cap = (cap.max(0.0) * f64::from(display.width)).ceil() as u32;
            needed_margin.map(|pixels| pixels.min(cap))
        }
    };
    let window = display.grown(margin[0], margin[1]);

    // Take the pinhole picture
    let pinhole = camera.pinhole();
    let samples = 0..settings.color_samples.div_ceil(2);
    let color_progress = Share { whole: progress, from: 0, to: 500 };
    let color = render(scene, &pinhole, &window.into(), samples.clone(), settings.seed, &color_progress)?.picture();
    let depth = first_depth(scene, &pinhole, window);

    // Look into its pixels, and behind it where the lens can
    let mut rest = vec![None; window.area()];
    let mut found = vec![Vec::new(); window.area()];
    if settings.count > 1 {
        let inside = Inside { scene, camera: &pinhole, samples: samples.end, seed: settings.seed };
        let step = Share { whole: progress, from: 500, to: 700 };
        each_pixel(&mut rest, window, &step, |x, y| inside.rest(x, y, &depth))?;
    }
    if settings.count > 1 && camera.iris.radius() > 0.0 {
        let walk = Walk::new(scene, camera);
        let behind = Behind { walk, count: settings.count - 1, samples: samples.end, seed: settings.seed };
        let candidates = candidates::near_edges(&depth, camera);
        let mut centres = vec![Vec::new(); window.area()];
        let step = Share { whole: progress, from: 700, to: 850 };
        each_pixel(
            &mut centres,
            window,
            &step,
            |x, y| {
                if candidates.at(x, y) { behind.at_centre(x, y) } else { Vec::new() }
            },
        )?;
        let step = Share { whole: progress, from: 850, to: 1000 };
        let centres = Centres { window, met: &centres };
        each_pixel(&mut found, window, &step, |x, y| behind.surfaces(x, y, &centres))?;
    }

    // Put the layers together
    let known = Mask::filled(window, true);
    let mut layers = vec![Layer { color, depth, known }];
    layers.extend((1..settings.count).map(|index| hidden_layer(window, &found, index - 1)));
    let mut frame = Frame::new(display, layers)?;
    frame.camera = Some(*camera);
    frame.metres_per_unit = scene.metres_per_unit();
    if settings.count > 1 {
        frame = frame.with_rest(|x, y| rest[window.index(x, y)]);
    }
    // Say how far away images are, where mirrors or glass show any
    if settings.count > 1 && scene.bounces() > 0 {
        let optical = optical_depth(scene, camera, window);
        if optical != frame.layers()[0].depth {
            frame = frame.with_optical_depth(optical);
        }
    }
    Ok(LayeredFrame { frame, needed_margin, margin })
}

/// Planar depth of the first hit at the pixel centres.
fn first_depth(scene: &Scene, pinhole: &Camera, window: PixelWindow) -> Plane {
    let mut depth = Plane::filled(window, f32::INFINITY);
    depth.values_mut().par_chunks_mut(window.width as usize).enumerate().for_each(|(row, depths)| {
        for (column, depth) in depths.iter_mut().enumerate() {
            let (x, y) = (window.x + column as i32, window.y + row as i32);
            let ray = pinhole_ray(pinhole, f64::from(x) + 0.5, f64::from(y) + 0.5);
            if let Some(hit) = scene.hit(&ray) {
                *depth = pinhole.pose.point_to_camera(hit.point).z as f32;
            }
        }
    });
    depth
}

/// The layer of every pixel's `index`-th hidden surface.
fn hidden_layer(window: PixelWindow, found: &[Vec<Surface>], index: usize) -> Layer {
    let at = |x: i32, y: i32| found[window.index(x, y)].get(index);
    let color = Picture::from_fn(window, |x, y| {
        at(x, y).map_or([0.0; 4], |surface| (surface.color * surface.cover).extend(surface.cover).to_array())
    });
    let depth = Plane::from_fn(window, |x, y| at(x, y).map_or(f32::INFINITY, |surface| surface.depth));
    let known = Mask::from_fn(window, |x, y| at(x, y).is_some());
    Layer { color, depth, known }
}

/// Work that is a part of a whole of 1000 steps.
struct Share<'a> {
    whole: &'a dyn Progress,
    from: u64,
    to: u64,
}

impl Progress for Share<'_> {
    fn report(&self, done: u64, total: u64) {
        self.whole.report(self.from + (self.to - self.from) * done / total.max(1), 1000);
    }

    fn is_cancelled(&self) -> bool {
        self.whole.is_cancelled()
    }
}

/// Fills what each pixel of a window has, in parallel.
fn each_pixel<T: Send>(
    values: &mut [T],
    window: PixelWindow,
    progress: &dyn Progress,
    value: impl Fn(i32, i32) -> T + Sync,
) -> Result<(), Cancelled> {
    values.par_chunks_mut(window.width as usize).enumerate().try_for_each(|(row, values)| {
        let y = window.y + row as i32;
        for (value_at, x) in values.iter_mut().zip(window.x..) {
            *value_at = value(x, y);
        }
        progress.report(row as u64 + 1, u64::from(window.height));
        if progress.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    })
}
