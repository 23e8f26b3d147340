//! What is sharp and what is not, drawn over the picture.

use rgbd::{Picture, Plane};

/// Radius in pixels of the circle of confusion up to which a pixel counts as sharp.
pub(super) const SHARP_PX: f32 = 1.0;

/// Across an edge of depth more than this lies between two neighbours, and no line of any plane.
const EDGE_PX: f32 = 0.75;

/// Tints and lines in linear light.
const NEAR: [f32; 3] = [1.0, 0.22, 0.0];
const FAR: [f32; 3] = [0.02, 0.15, 1.0];
const TRACE: [f32; 3] = [0.05, 0.9, 0.05];
const LIMIT: [f32; 3] = [1.0, 0.85, 0.0];

/// How strongly a zone is tinted.
const TINT: f32 = 0.35;

/// The picture with what is blurred in front of the sharp wedge tinted orange and behind it blue, the wedge's limits (a circle of
/// confusion of 1 px radius) drawn yellow and the trace of the plane of focus green. `coc` is signed, positive on the lens's
/// side, and of the picture's window; lines are two pixels wide from a picture of 1000 pixels on.
pub(super) fn overlay(picture: &Picture, coc: &Plane) -> Picture {
    let window = picture.window();
    let width = (window.width.max(window.height) / 500).clamp(1, 8) as i32;

    // Tint the zones
    let mut drawn = Picture::from_fn(window, |x, y| {
        let [r, g, b, _] = picture.at(x, y);
        let radius = coc.at(x, y);
        let tint = if radius > SHARP_PX {
            Some(NEAR)
        } else if radius < -SHARP_PX {
            Some(FAR)
        } else {
            None
        };
        let mixed = |c: usize, value: f32| match tint {
            Some(tint) => (1.0 - TINT) * value.clamp(0.0, 1.0) + TINT * tint[c] * 0.5,
            None => value.clamp(0.0, 1.0),
        };
        [mixed(0, r), mixed(1, g), mixed(2, b), 1.0]
    });

    // Draw where the radius passes the limits, then where it passes 0
    for (levels, color) in [(&[SHARP_PX, -SHARP_PX][..], LIMIT), (&[0.0][..], TRACE)] {
        for (x, y) in window.pixels() {
            let here = coc.at(x, y);
            let passes = [(x + 1, y), (x, y + 1)].into_iter().any(|(u, v)| {
                let there = coc.get(u, v).unwrap_or(here);
                let passed = levels.iter().any(|&level| (here > level) != (there > level));
                passed && (there - here).abs() <= EDGE_PX
            });
            if passes {
                for (u, v) in (0..width * width).map(|k| (x + k % width, y + k / width)) {
                    if window.contains(u, v) {
                        drawn.set(u, v, [color[0], color[1], color[2], 1.0]);
                    }
                }
            }
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;
    use rgbd::PixelWindow;

    #[test]
    fn zones_limits_and_trace_lie_where_the_radius_says() {
        // The radius falls by a tenth of a pixel for each column, from 4.05
        let window = PixelWindow::of_size(82, 4);
        let coc = Plane::from_fn(window, |x, _| 4.05 - 0.1 * x as f32);
        let drawn = overlay(&Picture::filled(window, [0.2, 0.2, 0.2, 1.0]), &coc);
        let rgb = |x: i32| {
            let [r, g, b, _] = drawn.at(x, 1);
            [r, g, b]
        };
        assert!(rgb(5)[0] > rgb(5)[2], "near is orange");
        assert!(rgb(75)[2] > rgb(75)[0], "far is blue");
        assert_eq!(rgb(36), [0.2; 3], "sharp is as it was");
        assert_eq!([rgb(40), rgb(30), rgb(50)], [TRACE, LIMIT, LIMIT]);
        // An edge of depth is no line of a plane
        let edge = Plane::from_fn(window, |x, _| if x < 40 { 9.0 } else { -9.0 });
        let drawn = overlay(&Picture::filled(window, [0.2, 0.2, 0.2, 1.0]), &edge);
        assert!(window.pixels().all(|(x, y)| drawn.at(x, y)[1] < 0.5));
    }
}
