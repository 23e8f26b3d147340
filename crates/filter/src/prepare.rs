//! From the layers of a frame to what is gathered: silhouettes taken apart, the hidden background filled in.

use optics::Camera;
use rgbd::PixelWindow;

use crate::{
    FrameView, Sides,
    beside::Beside,
    cells::Cells,
    fill::{FillLimits, fill},
    fragment::Fragment,
    surface::{Surface, pixel_q},
    unmix::{least_jump, neighbours, splits},
};

/// What a hidden pixel's neighbours on the same surface weigh beside it: hidden colour is a single sample in many files.
const HIDDEN_TENT: f32 = 0.3;

/// A view made ready to be gathered.
pub(crate) struct Prepared {
    /// The first layer; silhouette pixels hold what belongs to their own depth.
    pub(crate) first: Surface,
    /// Everything else, by pixel.
    pub(crate) fragments: Vec<Fragment>,
    /// The cells of the first surface.
    pub(crate) cells: Cells,
}

impl Prepared {
    /// Prepares a view's first `layers` layers; `reach` limits in pixels how far behind a silhouette is looked.
    pub(crate) fn new(view: &FrameView, camera: &Camera, layers: usize, reach: f32, sides: Sides) -> Self {
        let px = (camera.iris.radius() * camera.film.pixels_per_q().max_element()) as f32;
        let jump = least_jump(px);
        let mut first = Surface::new(view, camera, 0);
        let mut hidden: Vec<Surface> = (1..layers).map(|i| Surface::new(view, camera, i)).collect();
        // A frame with hidden layers may know what its pixels are made of; then all its colours are well sampled
        let rest = if layers > 1 { view.frame().rest() } else { None };
        if rest.is_none() {
            hidden.iter_mut().for_each(|surface| smooth(surface, jump));
        }

        // Give silhouette pixels to both their surfaces
        let cells = Cells::new(&first, rest, jump);
        let splits = splits(&first, &cells, rest, &hidden, jump);
        let mut fragments = Vec::new();
        first.doubt = vec![0.0; first.cover.len()];
        for split in &splits {
            let (i, share) = (split.index, split.share);
            first.doubt[i] = split.doubt;
            if split.is_near {
                first.cover[i] = share;
                first.rgba[i] = split.near.map(|c| c * share);
                let farther = first.inverse_depth[i];
                let behind = hidden.iter_mut().find(|s| s.cover[i] > 0.5 && s.inverse_depth[i] < farther);
                if let Some(behind) = behind {
                    behind.rgba[i] = split.far.map(|c| c * behind.cover[i]);
                }
            } else if share > 0.0 {
                first.rgba[i] = split.far;
                fragments.push(Fragment {
                    index: i as u32,
                    cover: share,
                    is_before: true,
                    inverse_depth: split.other_depth.max(0.0),
                    slope: split.other_slope,
                    rgba: split.near.map(|c| c * share),
                    doubt: split.doubt,
                });
            }
        }

        // Add what lies behind
        let filled = fill(&first, &splits, &mut hidden, &FillLimits { px, jump, reach });
        for surface in &hidden {
            let there = (0..surface.cover.len()).filter(|&i| surface.cover[i] > 0.0);
            fragments.extend(there.map(|i| Fragment {
                index: i as u32,
                cover: surface.cover[i],
                is_before: false,
                inverse_depth: surface.inverse_depth[i],
                slope: surface.slopes[i],
                rgba: surface.rgba[i],
                doubt: 0.0,
            }));
        }
        fragments.extend(filled);
        fragments.sort_by_key(|fragment| fragment.index);
        let mut prepared = Self { first, fragments, cells };
        if sides != Sides::Both {
            prepared.sharpen(view, camera, sides);
            prepared.cells = prepared.cells.with_ranges_of(&prepared.first);
        }
        prepared
    }

    /// Puts what is not to be blurred into the plane of focus.
    fn sharpen(&mut self, view: &FrameView, camera: &Camera, sides: Sides) {
        let window = self.window();
        let focus = |i: usize| {
            let (x, y) = (i as i32 % window.width as i32 + window.x, i as i32 / window.width as i32 + window.y);
            camera.focus.inverse_depth(pixel_q(view, camera, x, y)) as f32
        };
        for (i, s) in self.first.inverse_depth.iter_mut().enumerate() {
            *s = sides.limited(*s, focus(i));
        }
        for fragment in &mut self.fragments {
            let limited = sides.limited(fragment.inverse_depth, focus(fragment.index as usize));
            if limited != fragment.inverse_depth {
                (fragment.inverse_depth, fragment.slope) = (limited, [0.0; 2]);
            }
        }
    }

    /// The first surface, what pixels hold beside it, and the cells.
    pub(crate) fn into_layers(self) -> (Surface, Beside, Cells) {
        let beside = Beside::new(&self.first, self.fragments);
        (self.first, beside, self.cells)
    }

    /// The pixels that it covers.
    pub(crate) fn window(&self) -> PixelWindow {
        self.first.window
    }
}

/// Lets the pixels of a hidden surface share their colour with their neighbours a little.
fn smooth(surface: &mut Surface, jump: f32) {
    let window = surface.window;
    let width = window.width as i32;
    let smoothed = |i: usize| {
        let (x, y) = (i as i32 % width, i as i32 / width);
        let (mut sum, mut total, slope) = (surface.rgba[i], 1.0, surface.slopes[i]);
        for (dx, dy) in neighbours(1) {
            let (u, v) = (x + dx, y + dy);
            if u < 0 || v < 0 || u >= width || v >= window.height as i32 {
                continue;
            }
            let j = (v * width + u) as usize;
            let rise = slope[0] * dx as f32 + slope[1] * dy as f32;
            if surface.cover[j] == 1.0 && (surface.inverse_depth[j] - surface.inverse_depth[i] - rise).abs() < jump {
                let weight = if dx * dy == 0 { HIDDEN_TENT } else { HIDDEN_TENT * HIDDEN_TENT };
                sum.iter_mut().zip(surface.rgba[j]).for_each(|(sum, c)| *sum += weight * c);
                total += weight;
            }
        }
        (i, sum.map(|c| c / total))
    };
    let colors: Vec<_> = (0..surface.cover.len()).filter(|&i| surface.cover[i] == 1.0).map(smoothed).collect();
    for (i, rgba) in colors {
        surface.rgba[i] = rgba;
    }
}
