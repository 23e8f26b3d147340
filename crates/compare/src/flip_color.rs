//! The colour spaces and the colour distance of FLIP (Andersson et al. 2020, sections 4.1.1 and 4.1.2).

/// X, Y, Z of the white D65 to which the spaces are relative: the row sums of the matrix below.
const WHITE: [f32; 3] = [0.950_428_5, 1.0, 1.088_900_4];

/// XYZ of linear Rec. 709, row by row.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [0.412_386_56, 0.357_591_5, 0.180_450_5],
    [0.212_636_8, 0.715_183, 0.072_180_2],
    [0.019_330_62, 0.119_197_17, 0.950_372_6],
];

/// Linear Rec. 709 of XYZ, row by row: the inverse of the above.
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.241_003_3, -1.537_399, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041_554_224],
    [0.055_639_423, -0.204_011_2, 1.057_148_9],
];

/// Exponent of the colour distance, q_c in the paper.
const QC: f32 = 0.7;
/// Share of the largest distance up to which errors are stretched, p_c.
const PC: f32 = 0.4;
/// What that distance is mapped to, p_t.
const PT: f32 = 0.95;

fn times(matrix: &[[f32; 3]; 3], [x, y, z]: [f32; 3]) -> [f32; 3] {
    matrix.map(|[a, b, c]| a * x + b * y + c * z)
}

/// XYZ over the white, of linear Rec. 709.
fn relative_xyz(rgb: [f32; 3]) -> [f32; 3] {
    let xyz = times(&XYZ_FROM_RGB, rgb);
    [0, 1, 2].map(|i| xyz[i] / WHITE[i])
}

/// YCxCz, the linear opponent space in which the eye's contrast sensitivity is applied.
pub(crate) fn ycxcz_from_rgb(rgb: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Linear Rec. 709 of YCxCz, clipped to 0..1.
fn rgb_from_ycxcz([luma, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (luma + 16.0) / 116.0;
    let xyz = [(y + cx / 500.0) * WHITE[0], y * WHITE[1], (y - cz / 200.0) * WHITE[2]];
    times(&RGB_FROM_XYZ, xyz).map(|value| value.clamp(0.0, 1.0))
}

/// CIELAB with a and b scaled by the lightness (Hunt effect: chroma shows less in the dark).
fn hunt_lab(rgb: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = relative_xyz(rgb)
        .map(|t| if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 });
    let lightness = 116.0 * y - 16.0;
    let chroma = 0.01 * lightness;
    [lightness, chroma * 500.0 * (x - y), chroma * 200.0 * (y - z)]
}

/// City-block in lightness, Euclidean in chroma (Abasi et al. 2020), to the power q_c.
fn hyab_power(a: [f32; 3], b: [f32; 3]) -> f32 {
    let d = [0, 1, 2].map(|i| a[i] - b[i]);
    (d[0].abs() + (d[1] * d[1] + d[2] * d[2]).sqrt()).powf(QC)
}

/// The colour distance of FLIP between two filtered colours in YCxCz, in [0, 1].
#[derive(Debug, Clone, Copy)]
pub(crate) struct ColorDistance {
    largest: f32,
}

impl ColorDistance {
    /// The distance whose unit is that from green to blue, the largest within Rec. 709.
    pub(crate) fn new() -> Self {
        Self { largest: hyab_power(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])) }
    }

    /// How far apart two colours look.
    pub(crate) fn between(self, a_ycxcz: [f32; 3], b_ycxcz: [f32; 3]) -> f32 {
        let distance = hyab_power(hunt_lab(rgb_from_ycxcz(a_ycxcz)), hunt_lab(rgb_from_ycxcz(b_ycxcz)));
        // Give most of the range to small distances
        let knee = PC * self.largest;
        if distance < knee { distance * PT / knee } else { PT + (distance - knee) / (self.largest - knee) * (1.0 - PT) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrices_undo_each_other_and_white_has_no_chroma() {
        const FLOAT_ROUNDING: f32 = 5e-6; // printed digits of the matrices
        let rgb = [0.2, 0.7, 0.4];
        let back = rgb_from_ycxcz(ycxcz_from_rgb(rgb));
        assert!(rgb.iter().zip(back).all(|(a, b)| (a - b).abs() < FLOAT_ROUNDING), "{back:?}");
        let [luma, cx, cz] = ycxcz_from_rgb([1.0; 3]);
        assert!((luma - 100.0).abs() < 1e-3 && cx.abs() < 1e-3 && cz.abs() < 1e-3, "{luma} {cx} {cz}");
    }

    #[test]
    fn green_and_blue_are_as_far_apart_as_can_be() {
        let distance = ColorDistance::new();
        let farthest = distance.between(ycxcz_from_rgb([0.0, 1.0, 0.0]), ycxcz_from_rgb([0.0, 0.0, 1.0]));
        assert!((farthest - 1.0).abs() < 1e-4, "{farthest}");
    }
}
