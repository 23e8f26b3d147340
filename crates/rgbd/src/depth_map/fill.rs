//! Holes of a map, filled from what is known around them.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::{Picture, Plane};

/// What a step of one pixel costs besides its change of colour, in square roots of light.
const STEP: f32 = 0.01;

/// Gives each unknown pixel (NaN) the depth of the known pixel that is nearest to it along a way on which the colour changes
/// least, so that a fill ends where a thing ends. No depth is averaged. Returns the filled depths and how many there are;
/// where nothing is known nothing is filled.
#[must_use]
pub fn fill_holes(mut depth: Plane, guide: &Picture) -> (Plane, usize) {
    let window = depth.window();
    assert_eq!(window, guide.window(), "the guide has the map's pixels");
    let (width, height) = (window.width as usize, window.height as usize);
    let roots = |i: usize| [0, 1, 2].map(|c| guide.planes()[c].values()[i].clamp(0.0, 16.0).sqrt());
    let change = |i: usize, j: usize| {
        let (a, b) = (roots(i), roots(j));
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f32>().sqrt()
    };
    let is_hole: Vec<bool> = depth.values().iter().map(|depth| depth.is_nan()).collect();

    // Dijkstra's shortest ways, from all known pixels beside a hole at once; costs as whole numbers keep the order exact
    let mut reached = vec![u64::MAX; if is_hole.contains(&true) { window.area() } else { 0 }];
    let mut open: BinaryHeap<Reverse<(u64, usize, usize)>> = BinaryHeap::new();
    let neighbours = |i: usize| {
        let (x, y) = (i % width, i / width);
        let sides = [
            (x > 0).then(|| i - 1),
            (x + 1 < width).then(|| i + 1),
            (y > 0).then(|| i - width),
            (y + 1 < height).then(|| i + width),
        ];
        sides.into_iter().flatten()
    };
    let cost = |i: usize, j: usize| ((STEP + change(i, j)) * 65536.0) as u64;
    for i in (0..window.area()).filter(|&i| !is_hole[i]) {
        for j in neighbours(i).filter(|&j| is_hole[j]) {
            open.push(Reverse((cost(i, j), j, i)));
        }
    }
    let mut filled = 0;
    while let Some(Reverse((so_far, i, source))) = open.pop() {
        if reached[i] != u64::MAX {
            continue;
        }
        reached[i] = so_far;
        filled += 1;
        depth.values_mut()[i] = depth.values()[source];
        for j in neighbours(i).filter(|&j| is_hole[j] && reached[j] == u64::MAX) {
            open.push(Reverse((so_far + cost(i, j), j, source)));
        }
    }
    (depth, filled)
}
