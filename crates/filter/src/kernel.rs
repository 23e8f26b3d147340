//! Discrete kernels that blur exactly as much as the iris they stand for.
//!
//! A pixel's colour is already an average over the pixel's box, and so is the result: the kernel between them must have
//! the variance of the *continuous* footprint, r^2/4 per axis for a disc. Coverage weights (the share of each pixel that
//! the disc covers) have more: 0.39 instead of 0.25 at r = 1. So the outline is drawn at an `edge` radius smaller than r,
//! with a ramp about one pixel wide, chosen so that the weights' measured variance on the pixel lattice is that of the
//! footprint; their sum is measured too, so that a flat surface receives exactly 1. An iris with an odd number of blades
//! is not symmetric to the lattice: a small one would shift the picture by up to 0.3 px. It has no shape to speak of, so
//! it is averaged with its mirror image: in equal parts up to 2 px, no longer from 4 px.
//!
//! A squeezed iris, or pixels that are not square, make an [`Oval`] of it. Kernels are drawn in iris coordinates, where the
//! oval is a disc again and pixels are closer one way than the other. There the edge alone could not give both axes their
//! variance, so that a kernel is drawn a little longer or shorter than the oval: up to a pixel it is nearly round.
//!
//! A kernel is `min(max(a - b m, 0), weight)` of a metric m of the offset: for a disc the *squared* distance, which
//! spares a root for every neighbour (the ramp then runs over the square, which is as good), for a polygon the distance
//! from the centre in units that make every side lie at the same m.

use optics::{ApertureShape, Camera};
use rayon::prelude::*;

use crate::{outline::Outline, oval::Oval};

/// Entries per pixel of radius.
const STEPS: f32 = 32.0;
/// Ovals to draw per pixel of radius.
const STRETCH_STEPS: f32 = 8.0;
/// Radius in pixels beyond which the closed form serves; the lattice sum differs from it by less than 0.3 % there.
const LAST_RADIUS: usize = 8;

/// The kernel of one footprint: the weight of a pixel is `min(max(a - b m, 0), weight)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Kernel {
    pub(crate) a: f32,
    pub(crate) b: f32,
    pub(crate) weight: f32,
}

impl Kernel {
    /// The kernel that ends at `edge`, where the next pixel is at least `step` away; both in iris coordinates.
    #[inline(always)]
    pub(crate) fn of_edge(outline: &Outline, edge: f32, step: f32, weight: f32) -> Self {
        match outline {
            // The ramp from e^2 - e to e^2 + e is one pixel wide; a disc smaller than half a pixel keeps to its pixel
            Outline::Disc => {
                let b = 0.5 / edge.max(0.5 * step * step);
                Self { a: weight * (0.5 + b * edge * edge), b: weight * b, weight }
            }
            Outline::Polygon { apothem, .. } => {
                let b = 0.5 / (apothem * edge.max(step)).min(0.5);
                Self { a: weight * (0.5 + b * apothem * edge), b: weight * b, weight }
            }
        }
    }

    /// This kernel and `by` times another.
    #[inline(always)]
    pub(crate) fn plus(&self, other: &Self, by: f32) -> Self {
        Self { a: self.a + by * other.a, b: self.b + by * other.b, weight: self.weight + by * other.weight }
    }

    /// The weight at a metric.
    #[inline(always)]
    pub(crate) fn at(&self, metric: f32) -> f32 {
        (self.a - self.b * metric).max(0.0).min(self.weight)
    }
}

/// The kernels of an iris by footprint radius in pixels.
#[derive(Debug, Clone)]
pub(crate) struct KernelTable {
    outline: Outline,
    oval: Oval,
    /// The kernels at radius i / STEPS.
    entries: Vec<Kernel>,
    /// By how much an oval of radius i / STRETCH_STEPS is drawn higher than it is, and narrower; none for a disc.
    stretches: Vec<f32>,
    area: f32,
    variance: f32,
}

impl KernelTable {
    /// The kernels of a camera's iris.
    pub(crate) fn of(camera: &Camera) -> Self {
        Self::new(camera.iris.shape(), Oval::of(camera))
    }

    fn new(shape: ApertureShape, oval: Oval) -> Self {
        let outline = Outline::new(shape);
        let (area, variance) = (shape.area(), shape.variance());
        let wanted = |radius: f32| oval.variances(variance * f64::from(radius * radius));
        let entries_of = |steps: f32| (0..=LAST_RADIUS * steps as usize).into_par_iter().map(move |i| i as f32 / steps);

        // Choose what to draw, and draw it
        let drawn = |radius| drawn_oval(&outline, oval, radius, wanted(radius)).0 / oval.0;
        let stretches = if oval.is_round() { Vec::new() } else { entries_of(STRETCH_STEPS).map(drawn).collect() };
        let kernel = |radius| {
            let drawn = Oval(oval.0 * stretch(&stretches, radius));
            drawn_kernel(&outline, drawn, radius, wanted(radius)).0
        };
        let entries = entries_of(STEPS).map(kernel).collect();
        Self { outline, oval, entries, stretches, area: area as f32, variance: variance as f32 }
    }

    /// Whether a disc's footprint is a disc.
    pub(crate) fn is_round(&self) -> bool {
        self.oval.is_round()
    }

    /// The outline that kernels are drawn with.
    pub(crate) fn outline(&self) -> &Outline {
        &self.outline
    }

    /// The kernel of a footprint of `radius` pixels.
    #[cfg(test)]
    pub(crate) fn at(&self, radius: f32) -> Kernel {
        self.with_slope(radius).0
    }

    /// The kernel of a footprint of `radius` pixels, and how it changes with the radius.
    #[inline(always)]
    pub(crate) fn with_slope(&self, radius: f32) -> (Kernel, Kernel) {
        let place = radius * STEPS;
        let i = place as usize;
        if let Some(&[low, high]) = self.entries.get(i..i + 2).and_then(|pair| <&[Kernel; 2]>::try_from(pair).ok()) {
            let t = place - i as f32;
            let step = Kernel { a: high.a - low.a, b: high.b - low.b, weight: high.weight - low.weight };
            (low.plus(&step, t), Kernel { a: 0.0, b: 0.0, weight: 0.0 }.plus(&step, STEPS))
        } else {
            self.large(radius)
        }
    }

    /// By how much the footprint of `radius` pixels is drawn higher than it is, and narrower: what an offset in iris
    /// coordinates is to be multiplied by along x, and divided by along y.
    #[inline(always)]
    pub(crate) fn stretch(&self, radius: f32) -> f32 {
        stretch(&self.stretches, radius)
    }

    /// The weight of the pixel at an offset in iris coordinates, in a footprint of `radius` pixels with this kernel.
    #[inline(always)]
    pub(crate) fn weight(&self, [x, y]: [f32; 2], radius: f32, kernel: &Kernel) -> f32 {
        let stretch = self.stretch(radius);
        self.outline.weight(x * stretch, y / stretch, kernel, self.mirror(radius))
    }

    /// The share of the mirrored outline in a footprint of `radius` pixels, 0 to 1/2.
    #[inline(always)]
    pub(crate) fn mirror(&self, radius: f32) -> f32 {
        mirrored_share(radius / self.oval.longer())
    }

    /// The same where the lattice no longer matters: a disc of edge e with its ramp has area pi e^2 and variance
    /// e^2 / 4 + 1 / 12, a polygon with a ramp of one pixel area A (e^2 + 1/12) and variance v (e^2 + 5/12), or nearly so.
    #[inline(always)]
    fn large(&self, radius: f32) -> (Kernel, Kernel) {
        match &self.outline {
            Outline::Disc => {
                // weight = 1 / (A e^2), a = weight (1 + e) / 2, b = weight / (2 e), and de/dr = r / e
                let edge = (radius * radius - 1.0 / 3.0).sqrt();
                let inverse = 1.0 / edge;
                let weight = inverse * inverse / self.area;
                let kernel = Kernel { a: 0.5 * weight * (1.0 + edge), b: 0.5 * weight * inverse, weight };
                let slope = radius * inverse * inverse;
                let change = Kernel {
                    a: slope * (0.5 * weight * edge - 2.0 * kernel.a),
                    b: -3.0 * slope * kernel.b,
                    weight: -2.0 * slope * weight,
                };
                (kernel, change)
            }
            Outline::Polygon { apothem, .. } => {
                let squared = radius * radius - (5.0 / 48.0) / self.variance;
                let edge = squared.sqrt();
                let weight = 1.0 / (self.area * (squared + 1.0 / 12.0));
                let kernel = Kernel::of_edge(&self.outline, edge, 1.0, weight);
                let weight_change = -2.0 * radius * self.area * weight * weight;
                let a_change = weight_change * (0.5 + apothem * edge) + weight * apothem * radius / edge;
                (kernel, Kernel { a: a_change, b: weight_change, weight: weight_change })
            }
        }
    }

    /// The kernel of a footprint of `radius` pixels for squares of `size` pixels, and how it changes with the radius.
    ///
    /// A square's own variance, `(size^2 - 1) / 12` more than a pixel's, is taken off the footprint's.
    #[inline(always)]
    pub(crate) fn of_squares(&self, radius: f32, size: f32) -> (Kernel, Kernel) {
        if size == 1.0 {
            return self.with_slope(radius);
        }
        let squared = (radius * radius - (size * size - 1.0) / (12.0 * self.variance)).max(0.25 * size * size);
        let own = squared.sqrt();
        let (kernel, change) = self.with_slope(own / size);
        let share = 1.0 / (size * size);
        let metric = share * self.outline.metric_scale(size);
        let of_radius = share * radius / (own * size);
        let scaled =
            |k: Kernel, by: f32, metric: f32| Kernel { a: k.a * by, b: k.b * by * metric, weight: k.weight * by };
        (scaled(kernel, share, metric / share), scaled(change, of_radius, metric / share))
    }
}

/// How much of its departure from an upright iris a footprint of `radius` pixels is drawn with, 0 to 1.
///
/// Where a kernel is hardly larger than its pixel, the weights of the pixels beside it are small differences of large numbers:
/// at r = 0.6 an ellipse drawn as it is would differ from a disc 17 times as much as it should. This share gives its
/// variances the ratio of the ellipse's; it was measured on the pixel lattice and is fitted within 0.02 up to 1 px. Beyond
/// 1.2 px what is measured varies around 1.
#[inline(always)]
pub(crate) fn ellipse_share(radius: f32) -> f32 {
    let square = radius * radius;
    let share = 0.14 * square;
    // 1 where both are equal, so that nothing is divided by less than 0.19
    share / (1.0 - 0.58 * square).max(share)
}

/// The share of the mirrored outline in a footprint whose shorter half axis is `shorter` pixels, 0 to 1/2.
#[inline(always)]
pub(crate) fn mirrored_share(shorter: f32) -> f32 {
    0.5 - (0.25 * (shorter - 2.0)).clamp(0.0, 0.5)
}

/// The stretch at a radius in a table of them; 1 beyond it.
#[inline(always)]
fn stretch(stretches: &[f32], radius: f32) -> f32 {
    let place = radius * STRETCH_STEPS;
    match stretches.get(place as usize..place as usize + 2) {
        Some(&[low, high]) => low + (place - (place as usize) as f32) * (high - low),
        _ => 1.0,
    }
}

/// The oval to draw for an `oval` of `radius`, so that the kernel has the `wanted` variance along both axes.
fn drawn_oval(outline: &Outline, oval: Oval, radius: f32, wanted: [f64; 2]) -> Oval {
    let long_axis = usize::from(oval.0 > 1.0);
    // From a disc to an oval that stays, with its ramp, within a pixel and a half of the real one
    let (mut low, mut high) = (1.0, (radius * oval.longer() + 1.5) / (radius + 0.5));
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        let (_, found) = drawn_kernel(outline, oval.with_longer(middle), radius, wanted);
        if found[long_axis] < wanted[long_axis] { low = middle } else { high = middle }
    }
    oval.with_longer(low)
}

/// The kernel with the largest edge whose weights, on the lattice of an oval, vary no more than is `wanted` along x and y
/// together; and their variances.
fn drawn_kernel(outline: &Outline, oval: Oval, radius: f32, wanted: [f64; 2]) -> (Kernel, [f64; 2]) {
    let step = 1.0 / oval.longer();
    let moments = |edge: f64| lattice_moments(outline, oval, &Kernel::of_edge(outline, edge as f32, step, 1.0), edge);
    let (mut low, mut high) = ((f64::from(radius) - 1.0).max(0.0), f64::from(radius) + 1.0);
    if !oval.is_round() {
        low = 0.0;
    }
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        let [x, y] = moments(middle).1;
        if x + y <= wanted[0] + wanted[1] { low = middle } else { high = middle }
    }
    let (sum, variances) = moments(low);
    (Kernel::of_edge(outline, low as f32, step, (1.0 / sum) as f32), variances)
}

/// Sum of a kernel's weights on the pixel lattice, and their variances along x and y; neither changes in the mirror.
fn lattice_moments(outline: &Outline, Oval(half_height): Oval, kernel: &Kernel, edge: f64) -> (f64, [f64; 2]) {
    let [columns, rows] = [half_height.recip(), half_height].map(|half| ((edge as f32 + 1.0) * half) as i32 + 1);
    let (mut sum, mut second) = (0.0, [0.0; 2]);
    // The quarters of a disc are alike
    let is_disc = matches!(outline, Outline::Disc);
    let first = |last: i32| if is_disc { 0 } else { -last };
    let times = |k: i32| if is_disc && k > 0 { 2.0 } else { 1.0 };
    for y in first(rows)..=rows {
        for x in first(columns)..=columns {
            let weight = times(x)
                * times(y)
                * f64::from(kernel.at(outline.metric(x as f32 * half_height, y as f32 / half_height)));
            sum += weight;
            second = [second[0] + weight * f64::from(x * x), second[1] + weight * f64::from(y * y)];
        }
    }
    (sum, second.map(|second| second / sum))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sum, centroid and variances along x and y of a kernel on the lattice.
    fn moments(table: &KernelTable, Oval(half_height): Oval, radius: f32) -> (f64, [f64; 2], [f64; 2]) {
        let kernel = table.at(radius);
        let n = 2 * radius as i32 + 5;
        let (mut sum, mut first, mut second) = (0.0, [0.0; 2], [0.0; 2]);
        for (y, x) in (-n..=n).flat_map(|y| (-n..=n).map(move |x| (y, x))) {
            let weight = f64::from(table.weight([x as f32 * half_height, y as f32 / half_height], radius, &kernel));
            sum += weight;
            first = [first[0] + weight * f64::from(x), first[1] + weight * f64::from(y)];
            second = [second[0] + weight * f64::from(x * x), second[1] + weight * f64::from(y * y)];
        }
        (sum, first.map(|f| f / sum), second.map(|s| s / sum))
    }

    #[test]
    fn every_kernel_sums_to_one_stays_in_place_and_has_the_variance_of_its_iris() {
        let polygons =
            [(3, 1.5), (5, 0.0), (6, 0.2)].map(|(blades, turn)| ApertureShape::polygon(blades, turn).unwrap());
        let shapes = [[ApertureShape::Disc].as_slice(), &polygons].concat();
        // Discs, 2x anamorphic, and as wide as can be
        for (shape, oval) in shapes.iter().flat_map(|&shape| [1.0, 2f32.sqrt(), 0.5].map(|half| (shape, Oval(half)))) {
            let table = KernelTable::new(shape, oval);
            // Radii between the entries too; the last ones use the closed form
            for radius in [0.0, 0.01, 0.3, 0.517, 1.0, 1.003, 2.49, 5.11, 11.7, 15.99, 16.4, 31.3] {
                let (sum, centroid, variances) = moments(&table, oval, radius);
                let wanted = oval.variances(shape.variance() * f64::from(radius * radius));
                let what = format!("{shape:?} {oval:?} radius {radius}");
                // 1 % of 1 is what interpolation and the lattice cost at worst (next to r = 0.5); a hidden layer that
                // is let in where a surface sums to less than 1 cares for more than that
                assert!((sum - 1.0).abs() < 0.01, "{what}: sum {sum}");
                // A twentieth of a pixel moves nothing that is seen; across an oval the lattice is coarser
                let still = 0.05 * f64::from(oval.longer()).powi(3);
                assert!(centroid[0].hypot(centroid[1]) < still, "{what}: centroid {centroid:?}");
                if oval.is_round() {
                    let [found, wanted] = [variances, wanted].map(|[x, y]| 0.5 * (x + y));
                    assert!((found - wanted).abs() < 0.01 * wanted + 0.001, "{what}: {found} {wanted}");
                    continue;
                }
                for (found, wanted) in variances.into_iter().zip(wanted) {
                    assert!((found - wanted).abs() < 0.03 * wanted + 0.02, "{what}: {found} {wanted}");
                }
            }
        }
    }

    #[test]
    fn a_small_ellipse_blurs_as_much_more_one_way_as_it_is_longer() {
        let table = KernelTable::new(ApertureShape::Disc, Oval(1.0));
        for (radius, height) in [0.2, 0.4, 0.6, 0.8, 0.9, 1.0].into_iter().flat_map(|r| [(r, 1.02_f32), (r, 1.1)]) {
            let kernel = table.at(radius);
            let departure = |height: f32| {
                let weight = |x: f32, y: f32| table.weight([x * height, y / height], radius, &kernel);
                let mut second = [0.0; 2];
                for (x, y) in (-4..=4).flat_map(|y| (-4..=4).map(move |x| (x as f32, y as f32))) {
                    second = [second[0] + weight(x, y) * x * x, second[1] + weight(x, y) * y * y];
                }
                (second[1] / second[0]).ln()
            };
            let wanted = 4.0 * height.ln();
            let found = departure(1.0 + ellipse_share(radius) * (height - 1.0));
            assert!((found - wanted).abs() < 0.2 * wanted, "radius {radius}: {found} instead of {wanted}");
            // Drawn as it is, it loses all weight on one side
            let full = departure(height);
            assert!(full.is_nan() || full > 2.5 * wanted, "radius {radius}: {full} instead of {wanted}");
        }
    }

    #[test]
    fn plain_coverage_weights_would_blur_too_much() {
        // Why the table is needed: the ramp drawn at r = 1 itself has a variance of 0.4, not 0.25
        let kernel = Kernel::of_edge(&Outline::Disc, 1.0, 1.0, 1.0);
        let (_, [variance, _]) = lattice_moments(&Outline::Disc, Oval(1.0), &kernel, 1.0);
        assert!(variance > 0.33, "{variance}");
    }
}
