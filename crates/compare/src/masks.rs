//! Where in a picture an error sits: near depth edges or in the interior, before, in or behind the plane of focus, in highlights.

use image::{GrayImage, Luma};
use imageproc::distance_transform::euclidean_squared_distance_transform;
use optics::Camera;
use rgbd::{Frame, Mask, PixelWindow, Plane};
use serde::Serialize;

use crate::{CompareError, Reference};

/// How much the blur diameter, in pixels, must span within 3x3 pixels to count as an edge.
pub const EDGE_JUMP_PX: f64 = 3.0;

/// Least reach of the edge mask, in pixels.
pub const LEAST_REACH_PX: f64 = 8.0;

/// Largest radius of the circle of confusion, in pixels, of what counts as in focus.
pub const IN_FOCUS_PX: f64 = 1.0;

/// The parts of a picture for which figures are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MaskKind {
    /// The whole display window.
    All,
    /// Pixels near a jump in blur.
    Edges,
    /// The rest.
    Interior,
    /// What is blurred and lies on the lens's side of the plane of focus.
    Near,
    /// What is blurred by [`IN_FOCUS_PX`] at most.
    InFocus,
    /// What is blurred and lies beyond the plane of focus.
    Far,
    /// Where the reference is brighter than white (1) in a channel.
    Highlights,
}

impl MaskKind {
    /// All of them, in the order of reports.
    pub const EVERY: [Self; 7] =
        [Self::All, Self::Edges, Self::Interior, Self::Near, Self::InFocus, Self::Far, Self::Highlights];

    /// Its name in reports.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::All => "all",
            Self::Edges => "edges",
            Self::Interior => "interior",
            Self::Near => "near",
            Self::InFocus => "in_focus",
            Self::Far => "far",
            Self::Highlights => "highlights",
        }
    }
}

/// The masks of a display window.
///
/// *Edges* are the pixels within `reach_px` (Euclidean, centre to centre) of a pixel whose 3x3 neighbourhood spans more
/// than [`EDGE_JUMP_PX`] in signed diameter of the circle of confusion; the *interior* is the rest. *Near*, *in focus* and
/// *far* go by each pixel's own circle of confusion; pixels of unknown depth are in none of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Masks {
    edges: Mask,
    /// Before, in or behind the plane of focus, row by row; `None` where the depth is unknown.
    zones: Vec<Option<MaskKind>>,
    highlights: Option<Mask>,
    reach_px: Option<f64>,
    largest_coc_radius_px: Option<f64>,
}

impl Masks {
    /// No depth is known: the whole window is one mask, edges and interior have no figures.
    #[must_use]
    pub fn without_depth(display: PixelWindow) -> Self {
        let zones = vec![None; display.area()];
        let edges = Mask::filled(display, false);
        Self { edges, zones, highlights: None, reach_px: None, largest_coc_radius_px: None }
    }

    /// The masks of a frame's display window for the blur of `camera`, from the depth of its first layer.
    ///
    /// Depth in the overscan counts where there is some, pixels of unknown depth do not. The reach is `reach_px` if
    /// given, else the largest radius of the circle of confusion in the display window, rounded up, and at least 8 px.
    pub fn from_frame(frame: &Frame, camera: &Camera, reach_px: Option<f64>) -> Result<Self, CompareError> {
        // Check that film and frame are of one size
        let (film, display) = (&camera.film, frame.display);
        if (film.width(), film.height()) != (display.width, display.height) {
            let (film_width, film_height) = (film.width(), film.height());
            return Err(CompareError::FilmMismatch { film_width, film_height, display });
        }
        if display.is_empty() {
            return Err(CompareError::NoPixel(display));
        }

        // Choose how far from a jump its error may reach
        let diameter = coc_diameter(frame, camera);
        let in_display = diameter.window().intersection(&display);
        let largest = in_display.pixels().map(|(x, y)| f64::from(diameter.at(x, y).abs()));
        let largest_radius = 0.5 * largest.filter(|d| d.is_finite()).fold(0.0, f64::max);
        let reach = reach_px.unwrap_or_else(|| largest_radius.ceil().max(LEAST_REACH_PX));
        if !(reach >= 0.0 && reach.is_finite()) {
            return Err(CompareError::BadReach(reach));
        }

        // Mark what is near a jump
        let jumps = jumps(&diameter);
        let near = within(&jumps, reach);
        let edges = Mask::from_fn(display, |x, y| near.window().contains(x, y) && near.at(x, y));
        let zones = display.pixels().map(|(x, y)| zone(0.5 * f64::from(diameter.get(x, y)?))).collect();
        Ok(Self { edges, zones, highlights: None, reach_px: Some(reach), largest_coc_radius_px: Some(largest_radius) })
    }

    /// The same with the highlights of a reference of the same window.
    #[must_use]
    pub fn with_highlights(self, reference: &Reference) -> Self {
        let bright = |i: usize| reference.rgb.at(i).iter().any(|&value| value > 1.0);
        let window = self.window();
        Self { highlights: Some(Mask::from_fn(window, |x, y| bright(window.index(x, y)))), ..self }
    }

    /// The window they cover.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.edges.window()
    }

    /// The pixels near a jump in blur.
    #[must_use]
    pub fn edges(&self) -> &Mask {
        &self.edges
    }

    /// How far the edges reach, in pixels; `None` without depth.
    #[must_use]
    pub fn reach_px(&self) -> Option<f64> {
        self.reach_px
    }

    /// The largest radius of the circle of confusion in the display window, in pixels; `None` without depth.
    #[must_use]
    pub fn largest_coc_radius_px(&self) -> Option<f64> {
        self.largest_coc_radius_px
    }

    /// Whether pixel `i` (row by row) belongs to a mask.
    #[must_use]
    pub fn holds(&self, kind: MaskKind, i: usize) -> bool {
        match kind {
            MaskKind::All => true,
            MaskKind::Edges => self.edges.bits()[i],
            MaskKind::Interior => !self.edges.bits()[i],
            MaskKind::Near | MaskKind::InFocus | MaskKind::Far => self.zones[i] == Some(kind),
            MaskKind::Highlights => self.highlights.as_ref().is_some_and(|mask| mask.bits()[i]),
        }
    }

    /// How many pixels belong to a mask.
    #[must_use]
    pub fn count(&self, kind: MaskKind) -> usize {
        match kind {
            MaskKind::All => self.window().area(),
            MaskKind::Edges => self.edges.count(),
            MaskKind::Interior => self.window().area() - self.edges.count(),
            _ => (0..self.window().area()).filter(|&i| self.holds(kind, i)).count(),
        }
    }

    /// The share of a mask in the display window, 0 to 1.
    #[must_use]
    pub fn share(&self, kind: MaskKind) -> f64 {
        self.count(kind) as f64 / self.window().area().max(1) as f64
    }

    /// The masks that have figures: all where no depth is known, else those with a pixel in them.
    #[must_use]
    pub fn kinds(&self) -> Vec<MaskKind> {
        let split = self.reach_px.is_some();
        let has_figures = |kind: &MaskKind| match kind {
            MaskKind::All => true,
            MaskKind::Highlights => self.count(*kind) > 0,
            _ => split && self.count(*kind) > 0,
        };
        MaskKind::EVERY.into_iter().filter(has_figures).collect()
    }
}

/// Where what is blurred by a signed radius lies; `None` for NaN.
fn zone(radius_px: f64) -> Option<MaskKind> {
    if radius_px.abs() <= IN_FOCUS_PX {
        Some(MaskKind::InFocus)
    } else if radius_px > 0.0 {
        Some(MaskKind::Near)
    } else if radius_px < 0.0 {
        Some(MaskKind::Far)
    } else {
        None
    }
}

/// Signed diameter of the circle of confusion in pixels over the data window; NaN where the depth is not known.
fn coc_diameter(frame: &Frame, camera: &Camera) -> Plane {
    let (first, display) = (&frame.layers()[0], frame.display);
    Plane::from_fn(frame.data(), |x, y| {
        if !first.known.at(x, y) {
            return f32::NAN;
        }
        let pixel = glam::DVec2::new(f64::from(x - display.x) + 0.5, f64::from(y - display.y) + 0.5);
        let q = camera.film.q_from_pixel(pixel);
        (2.0 * camera.coc_radius_px(q, 1.0 / f64::from(first.depth.at(x, y)))) as f32
    })
}

/// Where a 3x3 neighbourhood spans more than the allowed jump.
fn jumps(diameter: &Plane) -> Mask {
    Mask::from_fn(diameter.window(), |x, y| {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
            // A NaN leaves both as they are
            let d = diameter.get(x + dx, y + dy).unwrap_or(f32::NAN);
            (low, high) = (low.min(d), high.max(d));
        }
        f64::from(high - low) > EDGE_JUMP_PX
    })
}

/// The pixels within `reach` pixels of a set one.
fn within(marks: &Mask, reach: f64) -> Mask {
    let window = marks.window();
    let marked = GrayImage::from_fn(window.width, window.height, |x, y| {
        Luma([u8::from(marks.bits()[y as usize * window.width as usize + x as usize])])
    });
    let squared = euclidean_squared_distance_transform(&marked);
    let mut near = marks.clone();
    near.bits_mut().iter_mut().zip(squared.iter()).for_each(|(bit, &d2)| *bit = d2 <= reach * reach);
    near
}
