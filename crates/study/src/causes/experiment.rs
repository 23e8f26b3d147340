//! The pictures of the chain: the filter with some causes switched off.

use std::collections::HashMap;

use filter::{FrameView, GatherSettings, KernelRule, LensRaysSettings, Method};
use optics::{Camera, KernelModel};
use rgbd::{Mask, Picture, PixelWindow, Progress};
use trace::Scene;

use crate::{Cause, CausesSettings, StudyError, causes::SwitchedOff, causes::inputs::Inputs, step::Step};

/// Pixels, finer pixels, and every picture that was made of them.
pub(crate) struct Experiments {
    pixels: Inputs,
    fine: Inputs,
    /// Finer pixels along the side of a pixel.
    times: u32,
    near_silhouettes: Mask,
    lens_samples: u32,
    /// The kernel that the filter chose by itself for the first picture.
    kernel: Option<KernelModel>,
    made: HashMap<(SwitchedOff, bool), Picture>,
}

impl Experiments {
    /// Traces what is filtered.
    pub(crate) fn new(
        scene: &Scene,
        camera: &Camera,
        settings: &CausesSettings,
        progress: &dyn Progress,
    ) -> Result<Self, StudyError> {
        let step = |index: usize| Step { whole: progress, index, count: 2 };
        let pixels = Inputs::new(scene, camera, 1, settings, &step(0))?;
        let fine = Inputs::new(scene, camera, settings.fine, settings, &step(1))?;
        let near_silhouettes = pixels.near_silhouettes();
        let made = HashMap::new();
        let (times, lens_samples, kernel) = (settings.fine, settings.lens_samples, None);
        Ok(Self { pixels, fine, times, near_silhouettes, lens_samples, kernel, made })
    }

    /// The picture with some causes switched off.
    pub(crate) fn picture(&mut self, off: SwitchedOff, progress: &dyn Progress) -> Result<Picture, StudyError> {
        let step = |index: usize| Step { whole: progress, index, count: 2 };
        let [mixed, small] = [Cause::MixedColor, Cause::SmallDiscs].map(|cause| off.has(cause));
        if mixed && small {
            return self.filtered(off, true, progress);
        }
        let coarse = self.filtered(off, false, &step(0))?;
        if !mixed && !small {
            return Ok(coarse);
        }
        let fine = self.filtered(off, true, &step(1))?;
        let near = &self.near_silhouettes;
        Ok(Picture::from_fn(
            coarse.window(),
            |x, y| {
                if near.at(x, y) == mixed { fine.at(x, y) } else { coarse.at(x, y) }
            },
        ))
    }

    /// The kernel that the filter chooses by itself.
    pub(crate) fn kernel(&self) -> Option<KernelModel> {
        self.kernel
    }

    /// Filters pixels or finer ones, which are then averaged.
    fn filtered(&mut self, off: SwitchedOff, fine: bool, progress: &dyn Progress) -> Result<Picture, StudyError> {
        // What differs only in where its pixels come from is one picture
        let key = (off.with(Cause::MixedColor).with(Cause::SmallDiscs), fine);
        if let Some(picture) = self.made.get(&key) {
            return Ok(picture.clone());
        }
        let times = self.times;
        let inputs = if fine { &self.fine } else { &self.pixels };
        let frame = inputs.frame(off)?;
        let kernel = match self.kernel {
            _ if off.has(Cause::KernelShape) => KernelRule::Forced(KernelModel::Exact),
            Some(kernel) => KernelRule::Forced(kernel),
            None => KernelRule::default(),
        };
        let method = if off.has(Cause::Leakage) {
            // A pixel gets as many rays as its finer ones together
            let samples = if fine { self.lens_samples } else { self.lens_samples * times * times };
            Method::LensRays(LensRaysSettings { samples: samples.min(1 << 16), ..LensRaysSettings::default() })
        } else {
            Method::Merged(GatherSettings { kernel, ..GatherSettings::default() })
        };
        let filtered = filter::apply(&FrameView::whole(&frame), &inputs.camera, &method, inputs.display(), progress)?;
        self.kernel.get_or_insert(filtered.kernel);
        let picture = if fine { averaged(&filtered.picture, times as i32) } else { filtered.picture };
        self.made.insert(key, picture.clone());
        Ok(picture)
    }
}

/// The mean over squares of `times` by `times` pixels.
fn averaged(picture: &Picture, times: i32) -> Picture {
    let fine = picture.window();
    let window = PixelWindow::of_size(fine.width / times as u32, fine.height / times as u32);
    Picture::from_fn(window, |x, y| {
        let inside = (0..times).flat_map(|v| (0..times).map(move |u| (x * times + u, y * times + v)));
        let sum = inside.fold([0.0; 4], |sum: [f32; 4], (u, v)| {
            let rgba = picture.at(u, v);
            [0, 1, 2, 3].map(|c| sum[c] + rgba[c])
        });
        sum.map(|c| c / (times * times) as f32)
    })
}
