//! The ladder of methods: every way to make the picture.

use filter::{GatherSettings, LensRaysSettings, Method};
use serde::Serialize;

use crate::HybridSettings;

/// What methods have in common that are drawn alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Family {
    /// Rung 0: no blur.
    Pinhole,
    /// Rung 1: every pixel averages its own circle of confusion.
    OwnCoc,
    /// Rung 2: every neighbour contributes whose footprint covers the pixel.
    Gather,
    /// Rungs 3 and 4: the same with neighbours merged.
    Merged,
    /// Rung 5: rays through the layered picture.
    LensRays,
    /// Rung 6: filtered, and traced where that would be wrong.
    Hybrid,
    /// Rung 7: distributed ray tracing.
    Trace,
    /// Another program's picture.
    Candidate,
}

/// One way to make the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rung {
    /// The filter, from an RGB-D picture.
    Filter(Method),
    /// The filter, and the tracer where it would be wrong, from both.
    Hybrid(HybridSettings),
    /// The tracer, from the scene.
    Trace {
        /// Samples per pixel, an even number of at least 2: the tracer takes them in two halves.
        samples: u32,
    },
}

impl Rung {
    /// Every rung of the filter, from cheap to true, each with one layer and, where hidden layers make a difference and the
    /// picture has `layers` of them, with all.
    #[must_use]
    pub fn of_filter(layers: usize) -> Vec<Self> {
        let gather = |layers| GatherSettings { layers, ..GatherSettings::default() };
        let rays = |layers| LensRaysSettings { layers, ..LensRaysSettings::default() };
        let mut rungs = vec![Method::Pinhole, Method::OwnCoc(gather(1))];
        for layers in if layers > 1 { vec![1, layers] } else { vec![1] } {
            rungs.extend([
                Method::Gather(gather(layers)),
                Method::Merged(gather(layers)),
                Method::LensRays(rays(layers)),
            ]);
        }
        rungs.into_iter().map(Self::Filter).collect()
    }

    /// What it is drawn as.
    #[must_use]
    pub fn family(&self) -> Family {
        match self {
            Self::Filter(Method::Pinhole) => Family::Pinhole,
            Self::Filter(Method::OwnCoc(_)) => Family::OwnCoc,
            Self::Filter(Method::Gather(_)) => Family::Gather,
            Self::Filter(Method::Merged(_)) => Family::Merged,
            Self::Filter(Method::LensRays(_)) => Family::LensRays,
            Self::Hybrid(_) => Family::Hybrid,
            Self::Trace { .. } => Family::Trace,
        }
    }

    /// How many layers of the RGB-D picture it uses; `None` for the tracer, which needs none.
    #[must_use]
    pub fn layers(&self) -> Option<usize> {
        match self {
            Self::Filter(Method::Pinhole | Method::OwnCoc(_)) => Some(1),
            Self::Filter(Method::Gather(settings) | Method::Merged(settings)) => Some(settings.layers),
            Self::Filter(Method::LensRays(settings)) => Some(settings.layers),
            Self::Hybrid(settings) => Some(settings.layers),
            Self::Trace { .. } => None,
        }
    }

    /// Rays for each pixel that gets some; `None` for methods without.
    #[must_use]
    pub fn samples(&self) -> Option<u32> {
        match self {
            Self::Filter(Method::LensRays(settings)) => Some(settings.samples),
            Self::Filter(_) => None,
            Self::Hybrid(settings) => Some(settings.samples),
            Self::Trace { samples } => Some(*samples),
        }
    }

    /// Error that it may leave in a pixel; `None` where none was asked for.
    #[must_use]
    pub fn tolerance(&self) -> Option<f32> {
        if let Self::Hybrid(settings) = self { Some(settings.tolerance) } else { None }
    }

    /// Its name in reports, such as `merged 2 layers`, `hybrid 0.01`, `hybrid 0.01 64` (with other than 256 samples) or
    /// `trace 256`.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Filter(method @ (Method::Pinhole | Method::OwnCoc(_))) => method.name().to_owned(),
            Self::Filter(method) => match self.layers() {
                Some(layers) if layers > 1 => format!("{} {layers} layers", method.name()),
                _ => format!("{} 1 layer", method.name()),
            },
            Self::Hybrid(HybridSettings { tolerance, samples, .. }) => {
                let usual = *samples == HybridSettings::default().samples;
                if usual { format!("hybrid {tolerance}") } else { format!("hybrid {tolerance} {samples}") }
            }
            Self::Trace { samples } => format!("trace {samples}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rung_stands_on_the_ladder_once_under_its_own_name() {
        let names: Vec<String> = Rung::of_filter(2).iter().map(Rung::name).collect();
        assert_eq!(
            names,
            [
                "pinhole",
                "own-coc",
                "gather 1 layer",
                "merged 1 layer",
                "lens-rays 1 layer",
                "gather 2 layers",
                "merged 2 layers",
                "lens-rays 2 layers"
            ]
        );
        assert_eq!(Rung::of_filter(1).len(), 5, "without hidden layers each once");
    }
}
