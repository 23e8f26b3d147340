//! The one picture type that crosses crate borders: colour and depth in layers.

use std::collections::BTreeMap;

use optics::Camera;
use thiserror::Error;

use crate::{Mask, Picture, PixelWindow, Plane, Primaries};

/// Why parts do not make a frame.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// A frame has at least one layer.
    #[error("a frame needs at least one layer")]
    NoLayer,
    /// A plane or layer covers other pixels than the frame's data window.
    #[error("{what} covers {found}, the frame's data window is {wanted}")]
    WindowMismatch {
        /// Which part.
        what: String,
        /// Its window.
        found: PixelWindow,
        /// The data window.
        wanted: PixelWindow,
    },
    /// A depth that is marked known is not in (0, +inf].
    #[error("depth {depth} at ({x}, {y}) of layer {layer} is marked known; known depth is positive or +inf")]
    BadDepth {
        /// Layer, 0 the nearest.
        layer: usize,
        /// Column.
        x: i32,
        /// Row.
        y: i32,
        /// The depth.
        depth: f32,
    },
}

/// One surface per pixel: premultiplied linear colour and planar depth.
///
/// Where a layer holds nothing (a hidden layer where no lens point sees a second surface) alpha is 0 and the depth is
/// not known; where a hidden surface fills only a part of a pixel alpha is that part. Where `known` is false but alpha is not
/// 0 there is a surface at an unknown depth (a hole in a sensor's depth). A known depth is in (0, +inf]; +inf is the sky. An unknown depth is stored as +inf and must not be used.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Colour, premultiplied and linear.
    pub color: Picture,
    /// Planar depth along the sensor's normal, in scene units.
    pub depth: Plane,
    /// Where the depth is known.
    pub known: Mask,
}

impl Layer {
    /// A layer from colour and raw depth: depths outside (0, +inf], NaN included, become unknown.
    #[must_use]
    pub fn from_raw_depth(color: Picture, mut depth: Plane) -> Self {
        let known = Mask::from_fn(depth.window(), |x, y| depth.at(x, y) > 0.0);
        for (z, &is_known) in depth.values_mut().iter_mut().zip(known.bits()) {
            if !is_known {
                *z = f32::INFINITY;
            }
        }
        Self { color, depth, known }
    }

    /// The pixels it covers.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.depth.window()
    }

    /// The same layer on a larger window, empty where it is new; known to be infinitely far there if it `is_first`.
    fn covering(&self, window: PixelWindow, is_first: bool) -> Self {
        let old = self.window();
        let known = |x, y| if old.contains(x, y) { self.known.at(x, y) } else { is_first };
        Self {
            color: self.color.covering(window),
            depth: self.depth.covering(window, f32::INFINITY),
            known: Mask::from_fn(window, known),
        }
    }

    /// The part inside `window`, which must lie within the layer's own.
    #[must_use]
    pub fn cropped(&self, window: PixelWindow) -> Self {
        Self { color: self.color.cropped(window), depth: self.depth.cropped(window), known: self.known.cropped(window) }
    }
}

/// An RGB-D picture: layers of colour and depth, nearest first, with its windows and, where known, its camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// The picture proper; the camera's film covers exactly this.
    pub display: PixelWindow,
    /// Width of a pixel over its height.
    pub pixel_aspect: f32,
    /// What R, G and B mean.
    pub primaries: Primaries,
    /// Metres in one unit of depth, where known.
    pub metres_per_unit: Option<f64>,
    /// The camera, where known.
    pub camera: Option<Camera>,
    /// Planes that ride along (CoC, predicted error, albedo, ...), by name; all of the data window.
    pub planes: BTreeMap<String, Plane>,
    layers: Vec<Layer>,
}

impl Frame {
    /// A frame of these layers, nearest first; square pixels, Rec. 709, unit and camera unknown.
    ///
    /// Every layer must cover the same window, which becomes the data window, and every known depth lie in (0, +inf].
    pub fn new(display: PixelWindow, layers: Vec<Layer>) -> Result<Self, FrameError> {
        let data = layers.first().ok_or(FrameError::NoLayer)?.window();
        for (i, layer) in layers.iter().enumerate() {
            for (what, found) in [
                ("colour", layer.color.window()),
                ("depth", layer.depth.window()),
                ("known mask", layer.known.window()),
            ] {
                if found != data {
                    return Err(FrameError::WindowMismatch {
                        what: format!("{what} of layer {i}"),
                        found,
                        wanted: data,
                    });
                }
            }
            for (x, y) in data.pixels() {
                let depth = layer.depth.at(x, y);
                if layer.known.at(x, y) && (depth.is_nan() || depth <= 0.0) {
                    return Err(FrameError::BadDepth { layer: i, x, y, depth });
                }
            }
        }
        Ok(Self {
            display,
            pixel_aspect: 1.0,
            primaries: Primaries::REC709,
            metres_per_unit: None,
            camera: None,
            planes: BTreeMap::new(),
            layers,
        })
    }

    /// The pixels for which there is data; may be larger (overscan) or smaller than the display window.
    #[must_use]
    pub fn data(&self) -> PixelWindow {
        self.layers[0].window()
    }

    /// The layers, nearest first; there is at least one.
    #[must_use]
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// The layers, to take them apart.
    #[must_use]
    pub fn into_layers(self) -> Vec<Layer> {
        self.layers
    }

    /// The same frame with its first `count` layers only (at least one). The first alone is what any renderer writes, without
    /// the [`rest`](Self::rest) of its pixels and their [`optical_depth`](Self::optical_depth).
    #[must_use]
    pub fn with_layers(mut self, count: usize) -> Self {
        self.layers.truncate(count.max(1));
        if count > 1 { self } else { self.without_rest().without_optical_depth() }
    }

    /// The same frame with the colour (premultiplied, linear) of every pixel of every layer replaced by a function of it. The
    /// [`rest`](Self::rest) of its pixels is forgotten: parts of a colour do not add up to a function of it.
    #[must_use]
    pub fn map_color(mut self, color: impl Fn([f32; 4]) -> [f32; 4]) -> Self {
        self = self.without_rest();
        for layer in &mut self.layers {
            layer.color = layer.color.map(&color);
        }
        self
    }

    /// The same frame with data for all of `window` too: what is added is empty (alpha 0) and infinitely far, which is
    /// what a data window smaller than the picture means. Further planes are 0 there.
    #[must_use]
    pub fn covering(self, window: PixelWindow) -> Self {
        if self.data().contains_window(&window) {
            return self;
        }
        let window = self.data().union(&window);
        Self {
            planes: self.planes.iter().map(|(name, plane)| (name.clone(), plane.covering(window, 0.0))).collect(),
            layers: self.layers.iter().enumerate().map(|(i, layer)| layer.covering(window, i == 0)).collect(),
            ..self
        }
    }

    /// The same frame with its data window reduced to `window`, which must lie within it.
    #[must_use]
    pub fn cropped(&self, window: PixelWindow) -> Self {
        Self {
            planes: self.planes.iter().map(|(name, plane)| (name.clone(), plane.cropped(window))).collect(),
            layers: self.layers.iter().map(|layer| layer.cropped(window)).collect(),
            ..*self
        }
    }
}
