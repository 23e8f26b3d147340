//! Clipped highlights given back some of the light that they lost.
//!
//! A picture that was made for a display ends at white: a lamp and a sheet of paper may hold the same value. Blurred, the
//! lamp's disc then is as dim as a disc of paper, where a real lens would draw it bright. How bright the lamp was nobody
//! knows; so, as in other programs (Nuke's ZDefocus: bloom threshold and gain; Photoshop's lens blur: threshold and
//! brightness of specular highlights), what lies between a threshold and white is stretched to a range that the user
//! names. Meylan, Daly and Süsstrunk, "The Reproduction of Specular Highlights on High Dynamic Range Displays" (CIC 2006),
//! bring highlights back to HDR displays by such a tone scale, of two straight parts; this one joins its parts smoothly.

use rgbd::Frame;

use crate::FilterError;

/// How clipped highlights are raised: a tone scale for the largest colour channel v of a pixel (linear; alpha divided out),
///
/// ```text
/// v' = v + (gain - 1) s(t),   s(t) = t^2 (3 - 2 t),   t = (v - threshold) / (1 - threshold), 0 to 1
/// ```
///
/// All three channels are multiplied by v' / v, so that the hue stays. White (1) becomes `gain`; what is below the
/// threshold stays as it is, bit for bit, and so does alpha; order is kept. What is already brighter than white was not
/// clipped, and gains no more than white does.
///
/// It is a step before the filter, on all layers of a frame:
///
/// ```
/// use filter::Highlights;
/// use rgbd::{Frame, Layer, Picture, PixelWindow, Plane};
///
/// // A lamp on a grey wall, clipped at white
/// let window = PixelWindow::of_size(3, 1);
/// let color = Picture::from_fn(window, |x, _| if x == 1 { [1.0, 0.8, 0.5, 1.0] } else { [0.5, 0.5, 0.5, 1.0] });
/// let frame = Frame::new(window, vec![Layer::from_raw_depth(color, Plane::filled(window, 2.0))])?;
///
/// // Take it to have been twenty times as bright
/// let frame = Highlights::new(20.0, Highlights::DEFAULT_THRESHOLD)?.recover(frame);
/// let color = &frame.layers()[0].color;
/// assert_eq!(color.at(1, 0), [20.0, 16.0, 10.0, 1.0]);
/// assert_eq!(color.at(0, 0), [0.5, 0.5, 0.5, 1.0]);
/// // ... and `filter::apply` draws bright discs of it
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Highlights {
    gain: f32,
    threshold: f32,
}

impl Highlights {
    /// The threshold unless another is asked for: the value 243 of 255 in sRGB.
    pub const DEFAULT_THRESHOLD: f32 = 0.9;

    /// Takes white to have been `gain` times as bright (1 to 65504, the largest half float), and whatever is above
    /// `threshold` (0 or more, less than 1; linear) to be partly clipped.
    pub fn new(gain: f32, threshold: f32) -> Result<Self, FilterError> {
        if !(1.0..=65504.0).contains(&gain) {
            let what = "gain of highlights";
            return Err(FilterError::BadSetting { what, value: f64::from(gain), wanted: "1 to 65504" });
        }
        if !(0.0..1.0).contains(&threshold) {
            let what = "threshold of highlights";
            return Err(FilterError::BadSetting {
                what,
                value: f64::from(threshold),
                wanted: "0 or more, less than 1",
            });
        }
        Ok(Self { gain, threshold })
    }

    /// What a premultiplied linear colour is raised to.
    #[must_use]
    pub fn recovered(&self, rgba: [f32; 4]) -> [f32; 4] {
        let [r, g, b, alpha] = rgba;
        // Colour without alpha is light that nothing covers, and is taken as it stands
        let cover = if alpha > 0.0 { alpha.min(1.0) } else { 1.0 };
        let brightest = r.max(g).max(b) / cover;
        if brightest.is_nan() || brightest <= self.threshold {
            return rgba;
        }
        let t = ((brightest - self.threshold) / (1.0 - self.threshold)).min(1.0);
        let factor = 1.0 + (self.gain - 1.0) * t * t * (3.0 - 2.0 * t) / brightest;
        [r * factor, g * factor, b * factor, alpha]
    }

    /// The same frame with the highlights of all its layers raised.
    #[must_use]
    pub fn recover(&self, frame: Frame) -> Frame {
        frame.map_color(|rgba| self.recovered(rgba))
    }
}
