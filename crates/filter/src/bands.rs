//! A picture that is too large for the memory goes through in bands.

use optics::Camera;
use rgbd::{Picture, PixelWindow, Plane, Progress};

use crate::{
    FilterError, Filtered, FrameView, Method, PredictedError,
    apply::{one_frame, reach_of_one},
    images::Images,
    tiles::TILE,
};

impl Method {
    /// What [`apply`](crate::apply) allocates at most, its result among it, as a multiple of the part of the frame that it may
    /// read.
    pub const MEMORY_FACTOR: u64 = 6;
}

/// Bytes that one pixel of one layer of a frame takes: colour, depth, and whether it is known.
const BYTES: u64 = 4 * 4 + 4 + 1;

/// What [`apply`](crate::apply) makes of the whole view, to the bit, with at most `memory_limit` bytes besides the frame and the result.
///
/// Where the limit is too small for the rows that a method reads around a band ([`reach_px`](crate::reach_px) above and below), bands are 64
/// rows high and take what they need. A window that leaves the view goes through whole.
pub fn apply_in_bands(
    view: &FrameView,
    camera: &Camera,
    method: &Method,
    window: PixelWindow,
    memory_limit: u64,
    progress: &dyn Progress,
) -> Result<Filtered, FilterError> {
    match Images::of(view.frame(), camera, method) {
        None => one_in_bands(view, camera, method, window, memory_limit, progress),
        Some(images) => images.composed(view, method, progress, |view, method, progress| {
            one_in_bands(view, camera, method, window, memory_limit, progress)
        }),
    }
}

/// The same for a frame without images.
fn one_in_bands(
    view: &FrameView,
    camera: &Camera,
    method: &Method,
    window: PixelWindow,
    memory_limit: u64,
    progress: &dyn Progress,
) -> Result<Filtered, FilterError> {
    let frame = view.frame();
    let width = u64::from(view.window().width.max(window.width));
    let row = Method::MEMORY_FACTOR * BYTES * frame.layers().len() as u64 * width;
    let rows = memory_limit / row.max(1);
    if rows >= u64::from(view.window().height.max(window.height)) || !view.window().contains_window(&window) {
        return one_frame(view, camera, method, window, progress);
    }

    // Cut at tiles, so that none is gathered twice
    let reach = reach_of_one(view, camera, method);
    let height = (rows.saturating_sub(2 * u64::from(reach)) as u32 / TILE * TILE).max(TILE);
    let cut = |y: i32| (y.div_euclid(TILE as i32) * TILE as i32 + height as i32).min(window.y_end());
    let starts = std::iter::successors(Some(window.y), |&y| Some(cut(y)).filter(|&end| end < window.y_end()));
    let bands: Vec<PixelWindow> =
        starts.map(|y| PixelWindow::from_corners(window.x, y, window.x_end(), cut(y))).collect();

    let mut joined: Option<(Filtered, Vec<Vec<f32>>)> = None;
    for (index, &band) in bands.iter().enumerate() {
        let progress = Part { progress, index: index as u64, count: bands.len() as u64 };
        let part = FrameView::part(frame, band.grown(reach, reach).intersection(&view.window()));
        let filtered = one_frame(&part, camera, method, band, &progress)?;
        let planes = planes(&filtered);
        match &mut joined {
            None => {
                // All of the window at once: a vector that grows takes twice what it holds
                let whole = |plane: &Plane| {
                    let mut values = Vec::with_capacity(window.area());
                    values.extend_from_slice(plane.values());
                    values
                };
                let values = planes.into_iter().map(whole).collect();
                joined = Some((filtered, values));
            }
            Some((whole, values)) => {
                values.iter_mut().zip(planes).for_each(|(all, plane)| all.extend_from_slice(plane.values()));
                whole.largest_radius_px = whole.largest_radius_px.max(filtered.largest_radius_px);
                whole.cut_to_px = whole.cut_to_px.or(filtered.cut_to_px);
            }
        }
    }
    let (whole, values) = joined.expect("a window has rows");
    Ok(with_planes(whole, window, values))
}

/// All planes of a result: the picture's, then those of the predicted error.
fn planes(filtered: &Filtered) -> Vec<&Plane> {
    let error = filtered.predicted_error.iter().flat_map(|error| std::iter::once(&error.total).chain(&error.causes));
    filtered.picture.planes().iter().chain(error).collect()
}

/// The result with other values in its planes.
fn with_planes(filtered: Filtered, window: PixelWindow, values: Vec<Vec<f32>>) -> Filtered {
    let mut planes =
        values.into_iter().map(|values| Plane::from_values(window, values).expect("bands that fill the window"));
    let mut next = || planes.next().expect("as many planes as before");
    let picture = Picture::from_planes([(); 4].map(|()| next())).expect("planes of one window");
    let predicted_error =
        filtered.predicted_error.is_some().then(|| PredictedError { total: next(), causes: [(); 4].map(|()| next()) });
    Filtered { picture, predicted_error, ..filtered }
}

/// The progress of one of some parts.
pub(crate) struct Part<'a> {
    pub(crate) progress: &'a dyn Progress,
    pub(crate) index: u64,
    pub(crate) count: u64,
}

impl Progress for Part<'_> {
    fn report(&self, done: u64, total: u64) {
        self.progress.report(self.index * total + done, self.count * total);
    }

    fn is_cancelled(&self) -> bool {
        self.progress.is_cancelled()
    }
}
