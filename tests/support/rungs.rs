//! The rungs of the ladder, cheapest first.

use filter::{GatherSettings, LensRaysSettings, Method};

/// Name, method, and the least number of layers that it needs to differ from the rung before.
pub(crate) fn all() -> Vec<(&'static str, Method, usize)> {
    let one_layer = GatherSettings { layers: 1, ..GatherSettings::default() };
    let all_layers = GatherSettings::default();
    let rays = |samples, layers| Method::LensRays(LensRaysSettings { samples, layers, ..LensRaysSettings::default() });
    vec![
        ("0 pinhole", Method::Pinhole, 1),
        ("1 own-coc", Method::OwnCoc(one_layer), 1),
        ("2 gather 1", Method::Gather(one_layer), 1),
        ("2 gather 2", Method::Gather(all_layers), 2),
        ("3 merged 1", Method::Merged(one_layer), 1),
        ("3 merged 2", Method::Merged(all_layers), 2),
        ("5 rays 1", rays(64, 1), 1),
        ("5 rays 2", rays(64, usize::MAX), 2),
    ]
}
