//! How far a filtered pixel may be from the truth.

use rgbd::{Picture, Plane};

/// Pixels between the places at which a neighbourhood is looked at, and how many there are on each side.
const STEP: i32 = 4;
const STEPS: i32 = 2;

/// The predicted error of each pixel, root mean square over R, G and B: the doubt about the colours that it was gathered
/// from, and where part of its iris found nothing (`open`), that part times the contrast around.
pub(crate) fn predicted_error(picture: &Picture, doubt: &Plane, open: &Plane) -> Plane {
    let window = picture.window();
    Plane::from_fn(window, |x, y| {
        let (doubt, open) = (doubt.at(x, y), open.at(x, y));
        let missing = if open > 0.01 { open * contrast(picture, x, y) } else { 0.0 };
        doubt.hypot(missing)
    })
}

/// Standard deviation of the colour around a pixel, root mean square over R, G and B.
fn contrast(picture: &Picture, x: i32, y: i32) -> f32 {
    let window = picture.window();
    let (mut count, mut sum, mut squares) = (0.0, [0.0; 3], 0.0);
    for v in (-STEPS..=STEPS).map(|k| y + k * STEP) {
        for u in (-STEPS..=STEPS).map(|k| x + k * STEP).filter(|&u| window.contains(u, v)) {
            let [r, g, b, _] = picture.at(u, v);
            count += 1.0;
            for (sum, c) in sum.iter_mut().zip([r, g, b]) {
                *sum += c;
                squares += c * c;
            }
        }
    }
    let mean = sum.iter().map(|s| (s / count) * (s / count)).sum::<f32>();
    ((squares / count - mean).max(0.0) / 3.0).sqrt()
}
