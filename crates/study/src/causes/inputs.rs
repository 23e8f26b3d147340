//! What the experiments filter: the frame as it is shipped and without its faults, in pixels and in finer ones.

use optics::Camera;
use rgbd::{Frame, Layer, Mask, PixelWindow, Progress};
use trace::{LayerSettings, Margin, Scene};

use crate::{Cause, CausesSettings, StudyError, causes::SwitchedOff};

/// How much more often colour is sampled where it shall not be undersampled.
const MORE_SAMPLES: u32 = 4;

/// A jump of the blur's signed radius that makes a silhouette, in pixels.
const SILHOUETTE_PX: f64 = 0.5;

/// The frame of a view in pixels of one size, with everything in it: all margin, all layers, both colours.
pub(crate) struct Inputs {
    pub(crate) camera: Camera,
    whole: Frame,
    /// The same with colour, and what pixels are made of, of as few samples as are shipped, with two layers at most.
    sampled: Frame,
    /// The data window that is shipped.
    shipped: PixelWindow,
}

impl Inputs {
    /// Traces a view whose pixels are `fine` times finer than those of `camera`.
    pub(crate) fn new(
        scene: &Scene,
        camera: &Camera,
        fine: u32,
        settings: &CausesSettings,
        progress: &dyn Progress,
    ) -> Result<Self, StudyError> {
        let film = camera.film.resized(camera.film.width() * fine, camera.film.height() * fine);
        let camera = Camera { film: film.map_err(|_| StudyError::TooFine { fine })?, ..*camera };
        let samples = settings.color_samples.div_ceil(fine * fine).max(2);
        let wanted = LayerSettings {
            count: settings.most_layers,
            margin: Margin::Needed { cap: 1.0 },
            color_samples: samples.saturating_mul(MORE_SAMPLES),
            seed: settings.seed,
        };
        let whole = trace::layers(scene, &camera, &wanted, progress)?.frame;
        let data = whole.data();
        let few = LayerSettings {
            count: settings.most_layers.min(2),
            color_samples: samples,
            seed: settings.seed.wrapping_add(1),
            ..wanted
        };
        let sampled = trace::layers(scene, &camera, &few, progress)?.frame.covering(data).cropped(data);

        // Cut as much of the margin off as is missing where the frame is shipped
        let [columns, rows] = settings.margin.map(|pixels| pixels.saturating_mul(fine).min(1 << 20));
        let shipped = whole.display.grown(columns, rows).intersection(&data);
        Ok(Self { camera, whole, sampled, shipped })
    }

    /// The picture's pixels.
    pub(crate) fn display(&self) -> PixelWindow {
        self.whole.display
    }

    /// The frame with some faults switched off and the others in it.
    pub(crate) fn frame(&self, off: SwitchedOff) -> Result<Frame, StudyError> {
        let kept = |index: usize| match index {
            0 => true,
            1 => off.has(Cause::SecondLayer),
            _ => off.has(Cause::FurtherLayers),
        };
        let source = if off.has(Cause::SampledColor) { &self.whole } else { &self.sampled };
        let window = if off.has(Cause::Border) { self.whole.data() } else { self.shipped };
        let mut layers: Vec<Layer> = Vec::new();
        for (i, layer) in self.whole.layers().iter().enumerate().filter(|(i, _)| kept(*i)) {
            let mut layer = layer.clone();
            if i == 0 {
                layer.color = source.layers()[0].color.clone();
            }
            layers.push(layer.cropped(window));
        }

        // What pixels are made of is known to frames of more than one layer
        let mut frame = Frame::new(self.display(), layers)?;
        if frame.layers().len() > 1 {
            frame.planes = source.planes.iter().map(|(name, plane)| (name.clone(), plane.cropped(window))).collect();
        }
        Ok(frame)
    }

    /// The pixels whose blur has a silhouette in reach: a jump of the first layer's depth that no plane explains.
    pub(crate) fn near_silhouettes(&self) -> Mask {
        let (first, data, film) = (&self.whole.layers()[0], self.whole.data(), self.camera.film);
        let radius = |x: i32, y: i32| {
            let q = film.q_from_pixel(glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            self.camera.coc_radius_px(q, 1.0 / f64::from(first.depth.at(x, y)))
        };
        let mut near = Mask::filled(self.display(), false);
        for (x, y) in data.pixels().filter(|&(x, y)| data.contains(x - 1, y - 1) && data.contains(x + 1, y + 1)) {
            let middle = radius(x, y);
            let ends =
                [(1, 0), (0, 1), (1, 1), (1, -1)].map(|(dx, dy)| [radius(x - dx, y - dy), radius(x + dx, y + dy)]);
            let bend = ends.iter().map(|[a, b]| (a - 2.0 * middle + b).abs()).fold(0.0, f64::max);
            if bend > SILHOUETTE_PX {
                // As far as either side of the jump is blurred, and a pixel more
                let widest = ends.as_flattened().iter().fold(middle.abs(), |widest, r| widest.max(r.abs()));
                stamp(&mut near, (x, y), widest + 1.5);
            }
        }
        near
    }
}

/// Marks the pixels within `reach` of a place.
fn stamp(mask: &mut Mask, (x, y): (i32, i32), reach: f64) {
    let around = reach.ceil() as u32;
    let here = PixelWindow { x, y, width: 1, height: 1 }.grown(around, around).intersection(&mask.window());
    for (u, v) in here.pixels() {
        if f64::from(u - x).hypot(f64::from(v - y)) <= reach {
            mask.set(u, v, true);
        }
    }
}
