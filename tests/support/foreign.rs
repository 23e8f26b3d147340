//! A file of another program, and the picture that a lens would have taken of it.

use std::path::Path;

use filter::{FrameView, GatherSettings, Method};
use glam::DVec2;
use optics::{ApertureShape, Camera, Film, Pose, ThinLens};
use rgbd::{Frame, Picture, PixelWindow, Plane, ReadOptions, Silent, read_frame, write_png};

/// Where blur is cut, so that an empty background at infinity does not make the test slow.
const LARGEST_RADIUS_PX: f32 = 16.0;

/// A frame without a camera of its own, and the film that belongs to it.
pub(crate) struct Foreign {
    name: String,
    frame: Frame,
    film: Film,
}

/// What a lens made of it.
pub(crate) struct Taken {
    pub(crate) unfiltered: Picture,
    pub(crate) picture: Picture,
    /// Signed radius of the circle of confusion, pixels.
    pub(crate) coc: Plane,
}

impl Foreign {
    /// Reads `data/exr/NAME.exr`; its picture shows `horizontal_fov` (radians), and is empty where the file has no data.
    pub(crate) fn read(shared: &Path, name: &str, horizontal_fov: f64) -> Self {
        let path = shared.join("data/exr").join(format!("{name}.exr"));
        let frame = read_frame(&path, &ReadOptions::default()).expect("a file with colour and depth").value;
        assert_eq!(frame.camera, None, "{name} is not of this project");
        let display = frame.display;
        let film = Film::from_fov(horizontal_fov, display.width, display.height).expect("a film");
        Self { name: name.to_owned(), frame: frame.covering(display), film }
    }

    /// The picture proper.
    pub(crate) fn display(&self) -> PixelWindow {
        self.frame.display
    }

    /// The pixels that the file holds something in.
    pub(crate) fn content(&self) -> PixelWindow {
        let [.., alpha] = self.frame.layers()[0].color.planes();
        let filled = alpha.window().pixels().filter(|&(x, y)| alpha.at(x, y) > 0.0);
        let pixel = |(x, y)| PixelWindow { x, y, width: 1, height: 1 };
        filled.map(pixel).reduce(|all, pixel| all.union(&pixel)).expect("a pixel that is not empty")
    }

    /// The picture of `window` through `lens`, moved until pixel `focus` is sharp.
    pub(crate) fn take(&self, lens: ThinLens, focus: (i32, i32), window: PixelWindow) -> Taken {
        let (frame, film) = (&self.frame, self.film);

        // Focus at the depth of the pixel
        let ((x, y), layer) = (focus, &frame.layers()[0]);
        assert!(
            layer.known.at(x, y) && layer.depth.at(x, y).is_finite(),
            "{}: there is something at {focus:?}",
            self.name
        );
        let q = film.q_from_pixel(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
        let lens = lens.focused_at(q, f64::from(layer.depth.at(x, y))).expect("a depth that the lens can focus at");
        let camera =
            lens.camera(Pose::IDENTITY, film, lens.iris(ApertureShape::Disc)).expect("a lens seen from its front");
        let taken = self.filtered(&camera, window);

        // Leave the pictures where they can be looked at
        for (what, picture) in [("before", &taken.unfiltered), ("after", &taken.picture)] {
            let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}_{what}.png", self.name));
            write_png(&path, picture, 0.0).expect("a folder to write to");
        }
        assert!(taken.coc.at(x, y).abs() < 1e-3, "{}: the lens is focused at {focus:?}", self.name);
        taken
    }

    fn filtered(&self, camera: &Camera, window: PixelWindow) -> Taken {
        let view = FrameView::whole(&self.frame);
        // What blurs more than the limit is empty or even background, which looks the same however far it is spread
        let settings = GatherSettings { max_radius_px: Some(LARGEST_RADIUS_PX), ..GatherSettings::default() };
        let apply = |method| {
            let filtered = filter::apply(&view, camera, &method, window, &Silent);
            filtered.expect("a frame of the camera's size").picture
        };
        let coc = filter::coc_radius_px(&view, camera).cropped(window);
        Taken { unfiltered: apply(Method::Pinhole), picture: apply(Method::Gather(settings)), coc }
    }
}

impl Taken {
    /// Whether every value is a number, no colour is negative, and every alpha a share.
    pub(crate) fn is_sound(&self) -> bool {
        const ROUNDING: f32 = 1e-5; // of a sum of a few thousand weights
        let is_light = |value: &f32| value.is_finite() && *value >= 0.0;
        let finite = self.picture.planes().iter().all(|plane| plane.values().iter().all(is_light));
        let [.., alpha] = self.picture.planes();
        finite && alpha.values().iter().all(|alpha| (0.0..=1.0 + ROUNDING).contains(alpha))
    }

    /// How much detail is left where the radius of the circle of confusion lies within `radii`: the sum of squared
    /// differences of luminance from pixel to pixel, over that of the unfiltered picture.
    pub(crate) fn detail_left(&self, radii: std::ops::Range<f32>) -> f64 {
        let window = self.picture.window();
        let inner = PixelWindow::from_corners(window.x, window.y, window.x_end() - 1, window.y_end() - 1);
        let blurs = |x, y| radii.contains(&self.coc.at(x, y).abs());
        let detail = |picture: &Picture| -> f64 {
            let chosen = inner.pixels().filter(|&(x, y)| blurs(x, y));
            let steps = chosen.map(|(x, y)| {
                let here = luminance(picture, x, y);
                (luminance(picture, x + 1, y) - here).powi(2) + (luminance(picture, x, y + 1) - here).powi(2)
            });
            steps.sum()
        };
        detail(&self.picture) / detail(&self.unfiltered)
    }

    /// Mean luminance of a part, unfiltered and filtered.
    pub(crate) fn brightness(&self, part: PixelWindow) -> [f64; 2] {
        let mean =
            |picture: &Picture| part.pixels().map(|(x, y)| luminance(picture, x, y)).sum::<f64>() / part.area() as f64;
        [mean(&self.unfiltered), mean(&self.picture)]
    }

    /// The strips of `width` pixels along top, bottom, left and right.
    pub(crate) fn border(&self, width: u32) -> [(&'static str, PixelWindow); 4] {
        let w = self.picture.window();
        let inset = width as i32;
        [
            ("top", PixelWindow { height: width, ..w }),
            ("bottom", PixelWindow { y: w.y_end() - inset, height: width, ..w }),
            ("left", PixelWindow { width, ..w }),
            ("right", PixelWindow { x: w.x_end() - inset, width, ..w }),
        ]
    }
}

/// Luminance of Rec. 709.
fn luminance(picture: &Picture, x: i32, y: i32) -> f64 {
    let [r, g, b, _] = picture.at(x, y).map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}
