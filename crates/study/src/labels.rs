//! Words beside points, so that they cover neither each other nor the points.

/// A rectangle in pixels, y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rect {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Rect {
    /// The rectangle of that size around a point.
    pub(crate) fn around(x: f64, y: f64, width: f64, height: f64) -> Self {
        Self { x: x - 0.5 * width, y: y - 0.5 * height, width, height }
    }

    fn area(&self) -> f64 {
        self.width * self.height
    }

    /// Area in common with another.
    pub(crate) fn overlap(&self, other: &Self) -> f64 {
        let along = |a: f64, wa: f64, b: f64, wb: f64| ((a + wa).min(b + wb) - a.max(b)).max(0.0);
        along(self.x, self.width, other.x, other.width) * along(self.y, self.height, other.y, other.height)
    }
}

/// A point and the size of the words that go beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Labelled {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

/// Distances from the point at which words are tried, in pixels.
const GAPS: [f64; 5] = [8.0, 15.0, 24.0, 36.0, 50.0];

/// Directions that are tried, the best to read first.
const DIRECTIONS: [(f64, f64); 8] =
    [(1.0, 0.0), (-1.0, 0.0), (0.0, -1.0), (0.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];

/// Places the words of each point, the first ones first: as near as they lie free within `bounds`, else where they cover
/// least.
pub(crate) fn place_labels(points: &[Labelled], marker_px: f64, bounds: Rect) -> Vec<Rect> {
    let mut taken: Vec<Rect> =
        points.iter().map(|point| Rect::around(point.x, point.y, marker_px, marker_px)).collect();
    let mut placed = Vec::with_capacity(points.len());
    for point in points {
        let size = Rect { x: 0.0, y: 0.0, width: point.width, height: point.height };
        let covered = |label: &Rect| {
            let outside = label.area() - label.overlap(&bounds);
            4.0 * outside + taken.iter().map(|other| label.overlap(other)).sum::<f64>()
        };
        let tried = GAPS.into_iter().flat_map(|gap| DIRECTIONS.map(|direction| beside(point, size, gap, direction)));
        let mut best: Option<(f64, Rect)> = None;
        for label in tried {
            let cost = covered(&label);
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, label));
            }
            if cost == 0.0 {
                break;
            }
        }
        let (_, label) = best.expect("places are tried");
        taken.push(label);
        placed.push(label);
    }
    placed
}

/// The words at a distance from the point in a direction.
fn beside(point: &Labelled, size: Rect, gap: f64, (dx, dy): (f64, f64)) -> Rect {
    // Aslant the corner, not the middle, keeps the distance
    let slant = if dx != 0.0 && dy != 0.0 { std::f64::consts::FRAC_1_SQRT_2 } else { 1.0 };
    Rect::around(
        point.x + dx * (slant * gap + 0.5 * size.width),
        point.y + dy * (slant * gap + 0.5 * size.height),
        size.width,
        size.height,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Rect = Rect { x: 0.0, y: 0.0, width: 400.0, height: 300.0 };

    #[test]
    fn crowded_labels_cover_neither_each_other_nor_a_point_nor_the_border() {
        let at = |i: i32| Labelled {
            x: 200.0 + 12.0 * f64::from(i % 3),
            y: 150.0 + 9.0 * f64::from(i / 3),
            width: 70.0,
            height: 14.0,
        };
        let mut points: Vec<Labelled> = (0..6).map(at).collect();
        points.push(Labelled { x: 395.0, y: 4.0, width: 60.0, height: 14.0 });
        let labels = place_labels(&points, 10.0, BOUNDS);
        for (i, label) in labels.iter().enumerate() {
            assert!(label.overlap(&BOUNDS) > label.area() - 1e-9, "label {i} leaves the chart");
            assert!(labels[..i].iter().all(|other| label.overlap(other) == 0.0), "label {i} covers another");
            let markers = points.iter().map(|point| Rect::around(point.x, point.y, 10.0, 10.0));
            assert!(markers.into_iter().all(|marker| label.overlap(&marker) == 0.0), "label {i} covers a point");
        }
    }

    #[test]
    fn a_lonely_label_stands_right_beside_its_point() {
        let labels = place_labels(&[Labelled { x: 100.0, y: 100.0, width: 50.0, height: 14.0 }], 10.0, BOUNDS);
        assert_eq!(labels, [Rect { x: 108.0, y: 93.0, width: 50.0, height: 14.0 }]);
    }
}
