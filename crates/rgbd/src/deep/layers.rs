//! The layers that deep pixels fill.

use super::pixel::{Sample, Surfaces};
use super::{DeepTally, MOST_LAYERS};
use crate::convert::picture_from;
use crate::{Layer, PixelWindow, Plane};

/// Layers that grow in number as pixels need them.
pub(crate) struct GrowingLayers {
    window: PixelWindow,
    /// Red, green, blue, alpha and depth of each.
    layers: Vec<[Plane; 5]>,
    tally: DeepTally,
}

impl GrowingLayers {
    /// The first layer, empty: infinitely far.
    pub(crate) fn new(window: PixelWindow) -> Self {
        let mut layers = Self { window, layers: Vec::new(), tally: DeepTally::default() };
        layers.grow(f32::INFINITY);
        layers
    }

    /// One more layer, empty.
    fn grow(&mut self, depth: f32) {
        let [r, g, b, a] = [(); 4].map(|()| Plane::filled(self.window, 0.0));
        self.layers.push([r, g, b, a, Plane::filled(self.window, depth)]);
    }

    /// Puts the samples of a pixel, which are used up; those outside the window are only counted.
    pub(crate) fn put(&mut self, x: i32, y: i32, samples: &mut Vec<Sample>) {
        let count = samples.len() as u64;
        self.tally.samples += count;
        self.tally.most = self.tally.most.max(count);
        self.tally.empty += u64::from(count == 0);
        let Some(mut surfaces) = Surfaces::of(samples) else { return };
        if !self.window.contains(x, y) {
            return;
        }
        self.tally.merged += u64::from(surfaces.merge_beyond(MOST_LAYERS - 1));
        while self.layers.len() <= surfaces.hidden.len() {
            self.grow(f32::NAN);
        }
        let all = std::iter::once(surfaces.front).chain(surfaces.hidden);
        for (layer, Sample { depth, rgba: [r, g, b, a] }) in self.layers.iter_mut().zip(all) {
            for (plane, value) in layer.iter_mut().zip([r, g, b, a, depth]) {
                plane.set(x, y, value);
            }
        }
    }

    /// Counts samples that were volumes.
    pub(crate) fn count_volumes(&mut self, volumes: u64) {
        self.tally.volumes += volumes;
    }

    /// The layers, nearest first, and what was counted.
    pub(crate) fn finish(self) -> (Vec<Layer>, DeepTally) {
        let layer = |[r, g, b, a, depth]: [Plane; 5]| Layer::from_raw_depth(picture_from(vec![r, g, b, a]), depth);
        (self.layers.into_iter().map(layer).collect(), self.tally)
    }
}
