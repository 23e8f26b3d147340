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

/// Side of the square that the mark of a point takes, in pixels.
const MARK: f64 = 13.0;

/// What it costs, in square pixels of a covered line, to cover a square pixel of other words or of a mark, to leave the
/// bounds by one, and to stand a pixel farther from the point.
const COVERING: f64 = 20.0;
const LEAVING: f64 = 80.0;
const DISTANCE: f64 = 5.0;

/// Places the words of each point, the first ones first: near to it and within `bounds`, where they cover no other words
/// and no mark, and little of `lines`.
pub(crate) fn place_labels(points: &[Labelled], lines: &[Rect], bounds: Rect) -> Vec<Rect> {
    let mut taken: Vec<Rect> = points.iter().map(|point| Rect::around(point.x, point.y, MARK, MARK)).collect();
    let mut placed = Vec::with_capacity(points.len());
    for point in points {
        let covered = |label: &Rect, others: &[Rect]| others.iter().map(|other| label.overlap(other)).sum::<f64>();
        let cost = |(gap, label): &(f64, Rect)| {
            let outside = label.area() - label.overlap(&bounds);
            LEAVING * outside + COVERING * covered(label, &taken) + covered(label, lines) + DISTANCE * gap
        };
        let places = GAPS.into_iter().flat_map(|gap| DIRECTIONS.map(|direction| (gap, beside(point, gap, direction))));
        // The first of equals reads best
        let best = places.min_by(|a, b| cost(a).total_cmp(&cost(b)));
        let (_, label) = best.expect("places are tried");
        taken.push(label);
        placed.push(label);
    }
    placed
}

/// The words at a distance from the point in a direction.
fn beside(point: &Labelled, gap: f64, (dx, dy): (f64, f64)) -> Rect {
    // Aslant the corner, not the middle, keeps about the distance, and clears the mark's own corner
    let slant = if dx != 0.0 && dy != 0.0 { 0.85 } else { 1.0 };
    let (x, y) = (dx * (slant * gap + 0.5 * point.width), dy * (slant * gap + 0.5 * point.height));
    Rect::around(point.x + x, point.y + y, point.width, point.height)
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
        let labels = place_labels(&points, &[], BOUNDS);
        for (i, label) in labels.iter().enumerate() {
            assert!(label.overlap(&BOUNDS) > label.area() - 1e-9, "label {i} leaves the chart");
            assert!(labels[..i].iter().all(|other| label.overlap(other) == 0.0), "label {i} covers another");
            let markers = points.iter().map(|point| Rect::around(point.x, point.y, MARK, MARK));
            assert!(markers.into_iter().all(|marker| label.overlap(&marker) == 0.0), "label {i} covers a point");
        }
    }

    #[test]
    fn a_lonely_label_stands_right_beside_its_point() {
        let point = Labelled { x: 100.0, y: 100.0, width: 50.0, height: 14.0 };
        assert_eq!(place_labels(&[point], &[], BOUNDS), [Rect { x: 108.0, y: 93.0, width: 50.0, height: 14.0 }]);
        // But on the other side of a line
        let line = Rect { x: 100.0, y: 99.0, width: 200.0, height: 2.0 };
        assert_eq!(place_labels(&[point], &[line], BOUNDS), [Rect { x: 42.0, y: 93.0, width: 50.0, height: 14.0 }]);
    }
}
