//! What candidates are held against.

use rgbd::{Picture, PixelWindow, Plane, Truth};

use crate::{CompareError, GivenNoise, MaskKind, Masks, rgb::Rgb};

/// What is known about the noise of a reference.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum NoiseSource {
    /// Two independent halves and the share sqrt(na nb) / (na + nb) that their difference counts.
    Halves { halves: Box<[Rgb; 2]>, share: f64 },
    /// Figures, or nothing at all.
    Given(GivenNoise),
}

/// A reference picture over its display window, with what is known of its noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    display: PixelWindow,
    pub(crate) rgb: Rgb,
    pub(crate) noise: NoiseSource,
}

impl Reference {
    /// A traced truth, whose two halves tell its noise. Both must cover its display window.
    pub fn from_truth(truth: &Truth) -> Result<Self, CompareError> {
        let [a, b] = &truth.halves;
        let halves = [
            Rgb::from_picture(a, truth.display, "the first half of the reference")?,
            Rgb::from_picture(b, truth.display, "the second half of the reference")?,
        ];
        let rgb = Rgb::from_picture(&truth.picture(), truth.display, "the reference")?;

        // A half without samples tells nothing
        let [na, nb] = truth.samples.map(f64::from);
        let noise = if na > 0.0 && nb > 0.0 {
            NoiseSource::Halves { halves: Box::new(halves), share: (na * nb).sqrt() / (na + nb) }
        } else {
            NoiseSource::Given(GivenNoise::default())
        };
        Ok(Self { display: truth.display, rgb, noise })
    }

    /// A picture whose mean square noise is given by figures, where it is known. It must cover `display`.
    pub fn from_picture(picture: &Picture, display: PixelWindow, noise: GivenNoise) -> Result<Self, CompareError> {
        for (mask, value) in [("all", noise.all), ("edges", noise.edges), ("interior", noise.interior)] {
            if let Some(value) = value.filter(|value| !(*value >= 0.0 && value.is_finite())) {
                return Err(CompareError::BadNoise { mask, value });
            }
        }
        let rgb = Rgb::from_picture(picture, display, "the reference")?;
        Ok(Self { display, rgb, noise: NoiseSource::Given(noise) })
    }

    /// The pixels that are compared.
    #[must_use]
    pub fn display(&self) -> PixelWindow {
        self.display
    }

    /// How many of its pixels held a value that was not finite; they count as 0.
    #[must_use]
    pub fn non_finite(&self) -> usize {
        self.rgb.non_finite
    }

    /// The picture over the display window, as it is compared; alpha 1.
    #[must_use]
    pub fn picture(&self) -> Picture {
        crate::comparison::picture_of(&self.rgb, self.display)
    }

    /// Whether its noise comes from two halves of its own.
    #[must_use]
    pub fn has_halves(&self) -> bool {
        matches!(self.noise, NoiseSource::Halves { .. })
    }

    /// Mean square noise (over R, G and B) of the reference within a mask; `None` if it is not known.
    #[must_use]
    pub fn noise_mse(&self, masks: &Masks, kind: MaskKind) -> Option<f64> {
        match &self.noise {
            NoiseSource::Given(noise) => noise.of(kind, masks.share(MaskKind::Edges)),
            NoiseSource::Halves { halves, share } => {
                let [a, b] = halves.as_ref();
                let square = |i: usize| {
                    let (a, b) = (a.at(i), b.at(i));
                    (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>() / 3.0
                };
                let sum: f64 = (0..a.len()).filter(|&i| masks.holds(kind, i)).map(square).sum();
                Some(share * share * sum / masks.count(kind).max(1) as f64)
            }
        }
    }

    /// Squared error of each pixel of `candidate`, which must cover the display window: mean over R, G and B.
    ///
    /// With two halves A and B of the reference it is (C - A)(C - B), which is free of their noise in the mean and may be
    /// negative in a pixel; else (C - R)^2.
    pub fn squared_error(&self, candidate: &Picture) -> Result<Plane, CompareError> {
        let candidate = Rgb::from_picture(candidate, self.display, "the candidate")?;
        let mut plane = Plane::filled(self.display, 0.0);
        for (i, value) in plane.values_mut().iter_mut().enumerate() {
            *value = self.squared_error_at(&candidate, i) as f32;
        }
        Ok(plane)
    }

    /// The same of one pixel.
    pub(crate) fn squared_error_at(&self, candidate: &Rgb, i: usize) -> f64 {
        let [a, b] = match &self.noise {
            NoiseSource::Halves { halves, .. } => [&halves[0], &halves[1]],
            NoiseSource::Given(_) => [&self.rgb; 2],
        };
        let (a, b, c) = (a.at(i), b.at(i), candidate.at(i));
        (0..3).map(|k| (f64::from(c[k]) - f64::from(a[k])) * (f64::from(c[k]) - f64::from(b[k]))).sum::<f64>() / 3.0
    }
}
