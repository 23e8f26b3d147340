//! The one door to all methods.

use fearless_simd::Level;
use glam::DVec2;
use optics::{Camera, DepthRange, KernelChoice, KernelModel, Reading};
use rgbd::{Picture, PixelWindow, Plane, Progress};

use crate::{
    FilterError, FrameView, GatherSettings, KernelRule, LensRaysSettings,
    gather::{GatherRun, Gathered, gather},
    images::Images,
    lattice::SIDES_PER_RADIUS,
    lens_map::PixelLens,
    lens_points::MAX_SAMPLES,
    lens_rays::{RayRun, lens_rays},
    oval::Oval,
    own_coc::own_coc,
    predicted::{PredictedError, predicted_error},
    surface::{HOLE_REACH, NEAREST, pixel_q},
    tiles::TILE,
    unmix::UNMIX_REACH,
};

/// What a gather reads beyond the blur, in pixels: a tile is planned as a whole, and squares of 16 pixels are read whole,
/// with a margin of three quarters of their side.
const GATHER_REACH: u32 = TILE - 1 + 16 + 12;

/// What is read around a pixel to take it apart: pure pixels, what lies beside them, slopes, smoothed hidden colour,
/// rounding.
const PREPARE_REACH: u32 = UNMIX_REACH as u32 + 1 + 1 + 1 + 2;

/// A rung of the ladder of methods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// No blur at all: the first layer as it is.
    Pinhole,
    /// Every pixel averages its own circle of confusion.
    OwnCoc(GatherSettings),
    /// Every neighbour whose footprint covers the pixel contributes, nearest first.
    Gather(GatherSettings),
    /// The same, with neighbours merged where the blur is large.
    Merged(GatherSettings),
    /// Rays through points of the iris are marched through the surfaces.
    LensRays(LensRaysSettings),
}

impl Default for Method {
    /// The merged gather with its default settings.
    fn default() -> Self {
        Self::Merged(GatherSettings::default())
    }
}

impl Method {
    /// Its name on the command line and in reports.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Pinhole => "pinhole",
            Self::OwnCoc(_) => "own-coc",
            Self::Gather(_) => "gather",
            Self::Merged(_) => "merged",
            Self::LensRays(_) => "lens-rays",
        }
    }

    /// How many layers it uses; `None` if it blurs nothing.
    pub(crate) fn layers(&self) -> Option<usize> {
        self.settings().map(|settings| settings.layers)
    }

    /// The same without a predicted error, and whether it makes one.
    pub(crate) fn without_prediction(mut self) -> (Self, bool) {
        let mut predicts = false;
        match &mut self {
            Self::Gather(settings) | Self::Merged(settings) => {
                std::mem::swap(&mut settings.predict_error, &mut predicts);
            }
            Self::LensRays(settings) => std::mem::swap(&mut settings.predict_error, &mut predicts),
            Self::Pinhole | Self::OwnCoc(_) => {}
        }
        (self, predicts)
    }

    /// What all blurring methods share: kernel, largest blur and layers. Rays know no kernel but the exact one.
    fn settings(&self) -> Option<GatherSettings> {
        match *self {
            Self::Pinhole => None,
            Self::OwnCoc(settings) | Self::Gather(settings) | Self::Merged(settings) => Some(settings),
            Self::LensRays(LensRaysSettings { max_radius_px, layers, sides, predict_error, .. }) => {
                Some(GatherSettings {
                    kernel: KernelRule::Forced(KernelModel::Exact),
                    max_radius_px,
                    layers,
                    sides,
                    predict_error,
                })
            }
        }
    }
}

/// What a method made, and what it chose on the way.
#[derive(Debug, Clone, PartialEq)]
pub struct Filtered {
    /// The picture of the window that was asked for.
    pub picture: Picture,
    /// The kernel that ran.
    pub kernel: KernelModel,
    /// Why; `None` where it was forced, also by an iris or pixels that turn discs to ovals, or nothing blurs.
    pub kernel_choice: Option<KernelChoice>,
    /// Largest radius (of the wider axis) of the circle of confusion in pixels over the window, before any limit.
    pub largest_radius_px: f32,
    /// The limit that cut it, in pixels, if it did.
    pub cut_to_px: Option<f32>,
    /// How far each pixel may be from the truth, and why, where it was asked for.
    pub predicted_error: Option<PredictedError>,
    /// Share of the frame's pixels whose images in mirrors and glass were blurred by their optical depth.
    pub image_share: f32,
}

/// Puts the lens of `camera` onto the frame and returns the pixels of `window`.
///
/// The camera's film must be the frame's display window. Only pixels inside the view are read: for the same bits as from
/// the whole frame, the view must reach [`reach_px`] pixels beyond `window` (or to the end of the data). Pixels of
/// `window` without data receive what blurs onto them, else nothing (alpha 0). The result is the same for any number of
/// threads and any cut into windows.
///
/// Where the frame knows the [optical depth](rgbd::Frame::optical_depth) of what mirrors and glass show, that is blurred by it,
/// while what hides them, and what they hide, goes by their surface; it takes two runs of the method.
///
/// ```
/// use glam::{DVec2, DVec3};
/// use optics::{ApertureShape, Camera, Film, Focus, Iris, Pose};
/// use rgbd::{Frame, Layer, Picture, PixelWindow, Plane, Silent};
///
/// // A white card at 2 m before a dark wall at 4 m
/// let window = PixelWindow::of_size(64, 36);
/// let on_card = |x: i32| x < 32;
/// let color = Picture::from_fn(window, |x, _| if on_card(x) { [0.9, 0.9, 0.9, 1.0] } else { [0.1, 0.1, 0.1, 1.0] });
/// let depth = Plane::from_fn(window, |x, _| if on_card(x) { 2.0 } else { 4.0 });
/// let frame = Frame::new(window, vec![Layer::from_raw_depth(color, depth)])?;
///
/// // A lens of 20 cm radius, focused on the wall through a plane tilted by w.y
/// let camera = Camera {
///     pose: Pose::IDENTITY,
///     film: Film::from_fov(0.7, 64, 36)?,
///     focus: Focus::new(DVec3::new(0.0, 0.05, 0.25))?,
///     iris: Iris::upright(0.2, ApertureShape::Disc)?,
/// };
/// let view = filter::FrameView::whole(&frame);
/// let filtered = filter::apply(&view, &camera, &filter::Method::default(), window, &Silent)?;
///
/// // The card, out of focus, spreads over the sharp wall beside it
/// let wall = |x| filtered.picture.at(x, 18)[0];
/// assert!(wall(33) > 0.3 && wall(40) < 0.11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn apply(
    view: &FrameView,
    camera: &Camera,
    method: &Method,
    window: PixelWindow,
    progress: &dyn Progress,
) -> Result<Filtered, FilterError> {
    match Images::of(view.frame(), camera, method) {
        None => one_frame(view, camera, method, window, progress),
        Some(images) => images.composed(view, method, progress, |view, method, progress| {
            one_frame(view, camera, method, window, progress)
        }),
    }
}

/// The same for a frame whose surfaces show themselves.
pub(crate) fn one_frame(
    view: &FrameView,
    camera: &Camera,
    method: &Method,
    window: PixelWindow,
    progress: &dyn Progress,
) -> Result<Filtered, FilterError> {
    check(view, camera, method, window)?;
    let Some(settings) = method.settings() else { return Ok(unfiltered(view, window)) };

    // Find out how large the blur gets, and how simple its shape may be
    let depths = depth_range(view, &settings);
    let (model, kernel_choice) = kernel(depths, camera, settings.kernel);
    let largest_radius_px = largest_radius_px(depths, view, camera, window);
    let limit = max_radius_px(view, &settings);
    // Methods measure an oval by the disc of the same area
    let disc_limit = limit / Oval::of(camera).longer();

    // Bands of a picture must grow the same trees as the whole
    let largest_over_data = self::largest_radius_px(depths, view, camera, view.frame().data());
    let layers = view.frame().layers().len().min(settings.layers.max(1));
    let fill_reach = fill_reach(inverse_range(depths, view, camera), camera, limit);
    // The predicted error is a mean over neighbours
    let doubt = settings.predict_error && !matches!(method, Method::OwnCoc(_));
    let around = if doubt { window.grown(1, 1) } else { window };
    let Gathered { picture, doubt } = match method {
        Method::OwnCoc(_) => {
            Gathered { picture: own_coc(view, camera, model, disc_limit, window, progress)?, doubt: None }
        }
        Method::LensRays(LensRaysSettings { samples, .. }) => {
            let run = RayRun {
                samples: *samples,
                max_radius: disc_limit,
                largest_radius: largest_over_data,
                layers,
                sides: settings.sides,
                fill_reach,
                doubt,
            };
            lens_rays(view, camera, &run, around, progress)?
        }
        _ => {
            let run = GatherRun {
                model,
                max_radius: disc_limit,
                largest_radius: largest_over_data,
                layers,
                sides: settings.sides,
                fill_reach,
                merge: matches!(method, Method::Merged(_)),
                level: Level::new(),
                doubt,
            };
            gather(view, camera, &run, around, progress)?
        }
    };
    let predicted_error = doubt.map(|doubt| predicted_error(view, camera, settings.sides, window, &doubt));
    let picture = if around == window { picture } else { picture.cropped(window) };
    let cut_to_px = (largest_radius_px > limit).then_some(limit);
    Ok(Filtered {
        picture,
        kernel: model,
        kernel_choice,
        largest_radius_px,
        cut_to_px,
        predicted_error,
        image_share: 0.0,
    })
}

/// How many pixels around a window a method may look at on this frame; finite for each method.
///
/// That is at least the largest blur; where silhouettes are taken apart and hidden background is filled in, five times the
/// blur's difference over the frame's depths and up to 147 pixels more (squares, holes).
#[must_use]
pub fn reach_px(view: &FrameView, camera: &Camera, method: &Method) -> u32 {
    let reach = |view: &FrameView| reach_of_one(view, camera, method);
    let images = Images::of(view.frame(), camera, method);
    images
        .map_or_else(|| reach(view), |images| images.views(view).map(|view| reach(&view)).into_iter().fold(0, u32::max))
}

/// The same for a frame whose surfaces show themselves.
pub(crate) fn reach_of_one(view: &FrameView, camera: &Camera, method: &Method) -> u32 {
    let Some(settings) = method.settings() else { return 0 };
    let frame = view.frame();
    let inverse = inverse_range(depth_range(view, &settings), view, camera);
    let limit = max_radius_px(view, &settings);
    let largest = largest_of(inverse, view, camera, frame.data()).min(limit);
    // An ellipse is wider than the disc by most at a corner of the window; then ramp, slope and rounding
    let disc = camera.pixels_per_defocus().max_element() as f32;
    let corners = camera.film.corners().map(|q| PixelLens::new(camera, KernelModel::Exact, q));
    let oval = Oval::of(camera);
    let wider =
        corners.iter().map(|lens| (lens.stretch() / oval.longer()).max(lens.widest / disc.max(f32::MIN_POSITIVE)));
    let wider = 1.1 * wider.fold(1.0, f32::max);
    let blur = (largest * wider).ceil() as u32 + 4 + if has_holes(view) { HOLE_REACH as u32 } else { 0 };
    match method {
        Method::Pinhole | Method::OwnCoc(_) => blur,
        // A colour is taken from the mirrored place beyond a silhouette, which is half as far again from there
        Method::Gather(_) | Method::Merged(_) | Method::LensRays(_) => {
            let filled = fill_reach(inverse, camera, limit);
            // Pixels are interpolated between cells, of which the blur spans some sides
            let cells = (3.0 * largest / SIDES_PER_RADIUS).ceil() as u32;
            blur + cells
                + GATHER_REACH
                + PREPARE_REACH
                + (2.5 * filled).ceil() as u32
                + u32::from(settings.predict_error)
        }
    }
}

/// How far behind a silhouette the background is filled in at most, in pixels.
fn fill_reach(inverse: [f64; 2], camera: &Camera, limit: f32) -> f32 {
    // An edge and a background that are blurred by the limit each, on both sides of the plane of focus
    let px = camera.pixels_per_defocus().max_element() as f32;
    (2.0 * limit).min(px * inverse[1] as f32 + 1.0)
}

/// Signed radius (of the wider axis) of the circle of confusion in pixels of each pixel of the view, from the first layer's
/// depth: positive on the lens's side of the plane of focus. Pixels of unknown depth are NaN.
#[must_use]
pub fn coc_radius_px(view: &FrameView, camera: &Camera) -> Plane {
    let layer = &view.frame().layers()[0];
    Plane::from_fn(view.window(), |x, y| {
        if !layer.known.at(x, y) {
            return f32::NAN;
        }
        camera.coc_radius_px(pixel_q(view, camera, x, y), 1.0 / f64::from(layer.depth.at(x, y))) as f32
    })
}

fn check(view: &FrameView, camera: &Camera, method: &Method, window: PixelWindow) -> Result<(), FilterError> {
    let display = view.frame().display;
    let (film_width, film_height) = (camera.film.width(), camera.film.height());
    if (film_width, film_height) != (display.width, display.height) {
        return Err(FilterError::FilmMismatch { film_width, film_height, display });
    }
    if window.intersection(&view.window()).is_empty() {
        return Err(FilterError::NoData { wanted: window, data: view.window() });
    }
    if let Some(GatherSettings { max_radius_px: Some(limit), .. }) = method.settings()
        && !(limit >= 0.0 && limit.is_finite())
    {
        let what = "largest blur radius in pixels";
        return Err(FilterError::BadSetting { what, value: f64::from(limit), wanted: "0 or positive" });
    }
    if let Some(GatherSettings { kernel: KernelRule::Auto { tolerance_px }, .. }) = method.settings()
        && (tolerance_px.is_nan() || tolerance_px <= 0.0)
    {
        let what = "tolerance of the kernel in pixels";
        return Err(FilterError::BadSetting { what, value: tolerance_px, wanted: "positive" });
    }
    if let Method::LensRays(LensRaysSettings { samples, .. }) = method
        && !(1..=MAX_SAMPLES).contains(samples)
    {
        let what = "number of rays for each pixel";
        return Err(FilterError::BadSetting { what, value: f64::from(*samples), wanted: "1 to 65536" });
    }
    Ok(())
}

/// The first layer itself.
fn unfiltered(view: &FrameView, window: PixelWindow) -> Filtered {
    let color = &view.frame().layers()[0].color;
    let known = view.window();
    let pixel = |x, y| if known.contains(x, y) { color.at(x, y) } else { [0.0; 4] };
    Filtered {
        picture: Picture::from_fn(window, pixel),
        kernel: KernelModel::Disc,
        kernel_choice: None,
        largest_radius_px: 0.0,
        cut_to_px: None,
        predicted_error: None,
        image_share: 0.0,
    }
}

fn kernel(depths: Option<DepthRange>, camera: &Camera, rule: KernelRule) -> (KernelModel, Option<KernelChoice>) {
    // A squeezed iris, or pixels that are not square, make an ellipse of every disc
    let round = Oval::of(camera).is_round();
    match rule {
        KernelRule::Forced(model) => (if round { model } else { model.max(KernelModel::Ellipse) }, None),
        KernelRule::Auto { tolerance_px } => {
            let Some(depths) = depths else { return (KernelModel::Disc, None) };
            let choice = KernelModel::choose(camera, Reading::Gather, &depths, tolerance_px);
            if round || choice.model > KernelModel::Disc {
                (choice.model, Some(choice))
            } else {
                (KernelModel::Ellipse, None)
            }
        }
    }
}

/// Nearest and farthest known depth of the whole frame, in the layers that are used.
fn depth_range(view: &FrameView, settings: &GatherSettings) -> Option<DepthRange> {
    let (mut near, mut far) = (f32::INFINITY, 0.0);
    for layer in view.frame().layers().iter().take(settings.layers.max(1)) {
        for (&z, &known) in layer.depth.values().iter().zip(layer.known.bits()) {
            near = if known && z < near { z } else { near };
            far = if known && z > far { z } else { far };
        }
    }
    if let (true, Some(rest)) = (settings.layers > 1, view.frame().rest()) {
        let rests = view.frame().data().pixels().filter_map(|(x, y)| rest.at(x, y));
        (near, far) = rests.fold((near, far), |(near, far), rest| (near.min(rest.depth), far.max(rest.depth)));
    }
    DepthRange::new(f64::from(near), f64::from(far)).ok()
}

/// Farthest and nearest inverse depth of all that a frame may be taken for: guessed surfaces go as far as the sky, holes
/// beside no depth lie in the plane of focus.
fn inverse_range(depths: Option<DepthRange>, view: &FrameView, camera: &Camera) -> [f64; 2] {
    let near = depths.map_or(0.0, |depths| depths.inverse()[1].min(f64::from(NEAREST)));
    let [mut far, mut near] = [0.0, near];
    if has_holes(view) {
        for corner in corners(view, camera, view.frame().data()) {
            let focus = camera.focus.inverse_depth(corner);
            (far, near) = (focus.min(far), focus.max(near));
        }
    }
    [far, near]
}

/// Whether some pixel of the frame has no known depth.
fn has_holes(view: &FrameView) -> bool {
    view.frame().layers().iter().any(|layer| layer.known.count() < layer.window().area())
}

/// Largest radius over a window, from the frame's range of depth.
fn largest_radius_px(depths: Option<DepthRange>, view: &FrameView, camera: &Camera, window: PixelWindow) -> f32 {
    largest_of(depths.map_or([0.0, 0.0], |depths| depths.inverse()), view, camera, window)
}

/// Largest radius over a window of what lies between two inverse depths.
fn largest_of(inverse: [f64; 2], view: &FrameView, camera: &Camera, window: PixelWindow) -> f32 {
    let radii = corners(view, camera, window)
        .into_iter()
        .flat_map(|corner| inverse.map(|s| camera.coc_radius_px(corner, s).abs()));
    radii.fold(0.0, f64::max) as f32
}

/// Chief-ray directions of a window's corners.
fn corners(view: &FrameView, camera: &Camera, window: PixelWindow) -> [DVec2; 4] {
    let corners = [
        (window.x, window.y),
        (window.x_end(), window.y),
        (window.x, window.y_end()),
        (window.x_end(), window.y_end()),
    ];
    let display = view.frame().display;
    corners.map(|(x, y)| {
        let from_display = DVec2::new(f64::from(x) - f64::from(display.x), f64::from(y) - f64::from(display.y));
        camera.film.q_from_pixel(from_display)
    })
}

fn max_radius_px(view: &FrameView, settings: &GatherSettings) -> f32 {
    settings.max_radius_px.unwrap_or(0.25 * view.frame().display.width as f32)
}
