//! The outline of an iris, and the metric that kernels are drawn over.

use optics::ApertureShape;

use crate::kernel::Kernel;

/// The outline of an iris in the plane.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Outline {
    Disc,
    /// Unit normals of the sides, and their distance from the centre for a circumradius of 1.
    Polygon {
        normals: Vec<[f32; 2]>,
        apothem: f32,
    },
}

impl Outline {
    pub(crate) fn new(shape: ApertureShape) -> Self {
        match shape {
            ApertureShape::Disc => Self::Disc,
            ApertureShape::Polygon { blades, rotation } => {
                let wedge = std::f64::consts::TAU / f64::from(blades);
                let normal = |k: u32| {
                    let (sin, cos) = (rotation + wedge * (f64::from(k) + 0.5)).sin_cos();
                    [cos as f32, sin as f32]
                };
                Self::Polygon { normals: (0..blades).map(normal).collect(), apothem: (0.5 * wedge).cos() as f32 }
            }
        }
    }

    /// The metric m of an offset.
    #[inline(always)]
    pub(crate) fn metric(&self, x: f32, y: f32) -> f32 {
        match self {
            Self::Disc => x * x + y * y,
            Self::Polygon { normals, .. } => {
                normals.iter().map(|n| n[0] * x + n[1] * y).fold(f32::NEG_INFINITY, f32::max)
            }
        }
    }

    /// The metric of an offset that is scaled by 1 / `size`, over that of the offset itself.
    pub(crate) fn metric_scale(&self, size: f32) -> f32 {
        match self {
            Self::Disc => 1.0 / (size * size),
            Self::Polygon { .. } => 1.0 / size,
        }
    }

    /// Start and slope of the ramp of a kernel that is 1 inside and ends at `edge` pixels, neither small ones nor ovals being
    /// drawn sharper than a pixel.
    #[inline(always)]
    pub(crate) fn ramp(&self, edge: f32) -> [f32; 2] {
        let kernel = Kernel::of_edge(self, edge, 1.0, 1.0);
        [kernel.a, kernel.b]
    }

    /// The edge of a kernel.
    pub(crate) fn edge(&self, kernel: &Kernel) -> f32 {
        let metric = ((kernel.a - 0.5 * kernel.weight) / kernel.b).max(0.0);
        match self {
            Self::Disc => metric.sqrt(),
            Self::Polygon { apothem, .. } => metric / apothem,
        }
    }

    /// Change of the metric at an edge with the edge.
    #[inline(always)]
    pub(crate) fn metric_change(&self, edge: f32) -> f32 {
        match self {
            Self::Disc => 2.0 * edge,
            Self::Polygon { apothem, .. } => *apothem,
        }
    }

    /// The weight of the pixel at (x, y), the mirrored outline blended in.
    #[inline(always)]
    pub(crate) fn weight(&self, x: f32, y: f32, kernel: &Kernel, mirror: f32) -> f32 {
        let weight = kernel.at(self.metric(x, y));
        if mirror == 0.0 || matches!(self, Self::Disc) {
            return weight;
        }
        weight + mirror * (kernel.at(self.metric(-x, -y)) - weight)
    }
}
