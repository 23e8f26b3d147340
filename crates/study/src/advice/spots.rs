//! A few tiles that are traced well, to hold the filter against what is true.
//!
//! A prediction may lean to one side on a whole scene. So some tiles are traced with many samples, those more often that are
//! predicted to be wrong, and what is found in each counts by the reciprocal of its chance (Horvitz & Thompson 1952): the mean
//! over the picture is right on average whatever the prediction is worth, and its scatter between tiles tells how far it may be off.

use compare::{Exposures, flip_hdr_at};
use optics::Camera;
use rgbd::{Picture, PixelWindow, Plane, Progress};
use trace::{Accumulation, RenderError, Scene};

use crate::StudyError;

/// Side of a tile in pixels.
const SIDE: u32 = 16;

/// Pixels around a tile where HDR-FLIP sees it.
const MARGIN: u32 = 10;

/// Samples in each half of a pixel.
pub(crate) const HALF: u32 = 128;

/// One tile is drawn for so many pixels of the picture, but no fewer and no more than these.
const PIXELS_PER_DRAW: usize = 2400;
const DRAWS: [usize; 2] = [16, 64];

/// Tiles of a picture, traced.
pub(crate) struct Spots {
    display: PixelWindow,
    spots: Vec<Spot>,
    sums: Accumulation,
}

/// A tile that was drawn.
struct Spot {
    tile: PixelWindow,
    /// Chance that a draw meets it.
    chance: f64,
    /// How often it was drawn.
    hits: usize,
}

/// A mean over the picture that was found in some tiles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Found {
    pub(crate) mean: f64,
    /// Standard error of the mean.
    pub(crate) scatter: f64,
}

impl Spots {
    /// Draws tiles of `camera`'s picture by an error that is expected of each pixel, and traces them.
    pub(crate) fn new(
        scene: &Scene,
        camera: &Camera,
        expected: &Plane,
        seed: u64,
        progress: &dyn Progress,
    ) -> Result<Self, StudyError> {
        let display = expected.window();
        let spots = drawn(expected);
        let mut is_traced = vec![false; display.area()];
        for (x, y) in spots.iter().flat_map(|spot| spot.tile.pixels()) {
            is_traced[display.index(x, y)] = true;
        }
        let counts = |x: i32, y: i32| {
            let count = if is_traced[display.index(x, y)] { HALF } else { 0 };
            [0..count, 0..count]
        };
        let mut sums = Accumulation::new(*camera, display, seed);
        sums.extend(scene, &counts, progress).map_err(RenderError::from)?;
        Ok(Self { display, spots, sums })
    }

    /// Both halves of a pixel of a tile, and their mean.
    fn at(&self, x: i32, y: i32) -> ([[f32; 3]; 2], [f32; 3]) {
        let halves = self.sums.halves_at(x, y).expect("samples in every pixel of a tile");
        (halves, [0, 1, 2].map(|c| 0.5 * (halves[0][c] + halves[1][c])))
    }

    /// Mean square error of a picture of which a share of each pixel is left: what both halves of the trace agree on, so that
    /// their noise adds nothing on average.
    pub(crate) fn square_error(&self, picture: &Picture, left: impl Fn(i32, i32) -> f32) -> Found {
        self.found(|spot| {
            let square = |(x, y)| {
                let ([a, b], _) = self.at(x, y);
                let own = picture.at(x, y);
                let product: f32 = (0..3).map(|c| (a[c] - own[c]) * (b[c] - own[c])).sum();
                f64::from(product) / 3.0 * f64::from(left(x, y)).powi(2)
            };
            spot.tile.pixels().map(square).sum()
        })
    }

    /// Mean square noise of the tiles' samples, and of what `other` (mean square noise of each pixel) says of the same pixels:
    /// not of the picture, but of the tiles as they are.
    pub(crate) fn noises(&self, other: &Plane) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for (x, y) in self.spots.iter().flat_map(|spot| spot.tile.pixels()) {
            let ([a, b], _) = self.at(x, y);
            let own: f32 = (0..3).map(|c| 0.25 * (a[c] - b[c]).powi(2)).sum();
            sums[0] += f64::from(own) / 3.0;
            sums[1] += f64::from(other.at(x, y));
        }
        sums
    }

    /// Mean HDR-FLIP of a picture of which a share of each pixel is left. In it is the noise of as much of the trace.
    pub(crate) fn flip(
        &self,
        picture: &Picture,
        left: impl Fn(i32, i32) -> f32,
        exposures: Exposures,
    ) -> Result<Found, StudyError> {
        let candidate = |x: i32, y: i32| {
            let ((_, truth), own, left) = (self.at(x, y), picture.at(x, y), left(x, y));
            [0, 1, 2].map(|c| truth[c] + left * (own[c] - truth[c]))
        };
        self.flip_between(picture, |x, y| self.at(x, y).1, candidate, exposures)
    }

    /// Mean HDR-FLIP of the two halves of the tiles' samples, of which a share of each pixel is left.
    pub(crate) fn flip_of_halves(
        &self,
        around: &Picture,
        left: impl Fn(i32, i32) -> f32,
        exposures: Exposures,
    ) -> Result<Found, StudyError> {
        let candidate = |x: i32, y: i32| {
            let (([a, b], _), left) = (self.at(x, y), left(x, y));
            [0, 1, 2].map(|c| a[c] + left * (b[c] - a[c]))
        };
        self.flip_between(around, |x, y| self.at(x, y).0[0], candidate, exposures)
    }

    /// Mean HDR-FLIP of two pictures that are known in the tiles and the same `around` them. Tiles stand in a column, each with
    /// the margin that it is seen in.
    fn flip_between(
        &self,
        around: &Picture,
        reference: impl Fn(i32, i32) -> [f32; 3],
        candidate: impl Fn(i32, i32) -> [f32; 3],
        exposures: Exposures,
    ) -> Result<Found, StudyError> {
        let side = (SIDE + 2 * MARGIN) as i32;
        let column = PixelWindow::of_size(side as u32, side as u32 * self.spots.len() as u32);
        let in_column = |inside: &dyn Fn(i32, i32) -> [f32; 3]| {
            Picture::from_fn(column, |x, y| {
                let tile = self.spots[(y / side) as usize].tile;
                let (x, y) = (tile.x + x - MARGIN as i32, tile.y + y % side - MARGIN as i32);
                if tile.contains(x, y) {
                    let [r, g, b] = inside(x, y);
                    return [r, g, b, 1.0];
                }
                let display = self.display;
                around.at(x.clamp(display.x, display.x_end() - 1), y.clamp(display.y, display.y_end() - 1))
            })
        };
        let map = flip_hdr_at(&in_column(&reference), &in_column(&candidate), column, exposures)?;
        let block = (side * side) as usize;
        let sums: Vec<f64> =
            map.values().chunks(block).map(|block| block.iter().map(|&error| f64::from(error)).sum()).collect();
        let mut sums = sums.into_iter();
        Ok(self.found(|_| sums.next().expect("a block for every tile")))
    }

    /// Mean over the picture of a value of each pixel, from the tiles alone.
    pub(crate) fn mean(&self, values: &Plane) -> Found {
        self.found(|spot| spot.tile.pixels().map(|(x, y)| f64::from(values.at(x, y))).sum())
    }

    /// The mean over the picture of what sums to `sum` in each tile.
    fn found(&self, mut sum: impl FnMut(&Spot) -> f64) -> Found {
        let area = self.display.area() as f64;
        let estimates: Vec<(f64, f64)> =
            self.spots.iter().map(|spot| (spot.hits as f64, sum(spot) / (spot.chance * area))).collect();
        let draws: f64 = estimates.iter().map(|(hits, _)| hits).sum();
        let mean = estimates.iter().map(|(hits, value)| hits * value).sum::<f64>() / draws;
        let square = estimates.iter().map(|(hits, value)| hits * (value - mean).powi(2)).sum::<f64>();
        Found { mean, scatter: (square / (draws * (draws - 1.0))).sqrt() }
    }
}

/// Draws tiles, systematically: half by the square of the error expected in them, a third by the error, the rest by area.
fn drawn(expected: &Plane) -> Vec<Spot> {
    let display = expected.window();
    let steps = |from: i32, to: i32| (from..to).step_by(SIDE as usize);
    let tiles: Vec<PixelWindow> = steps(display.y, display.y_end())
        .flat_map(|y| steps(display.x, display.x_end()).map(move |x| (x, y)))
        .map(|(x, y)| PixelWindow { x, y, width: SIDE, height: SIDE }.intersection(&display))
        .collect();
    let sums = |power: i32| -> Vec<f64> {
        let sum = |tile: &PixelWindow| tile.pixels().map(|(x, y)| f64::from(expected.at(x, y)).powi(power)).sum();
        shares(tiles.iter().map(sum).collect())
    };
    let [squares, errors, areas] = [2, 1, 0].map(sums);
    let chances: Vec<f64> = (0..tiles.len()).map(|i| squares[i] / 2.0 + errors[i] / 3.0 + areas[i] / 6.0).collect();

    // Every draw is one step on the way through all chances
    let draws = (display.area() / PIXELS_PER_DRAW).clamp(DRAWS[0], DRAWS[1]);
    let (mut spots, mut passed, mut met) = (Vec::new(), 0.0, 0);
    for (tile, chance) in tiles.into_iter().zip(shares(chances)) {
        passed += chance * draws as f64;
        let hits = (0.5 + passed).floor() as usize - met;
        met += hits;
        if hits > 0 {
            spots.push(Spot { tile, chance, hits });
        }
    }
    spots
}

/// What each value is of their sum; all the same where that is nothing.
fn shares(values: Vec<f64>) -> Vec<f64> {
    let sum: f64 = values.iter().sum();
    let each = 1.0 / values.len() as f64;
    values.into_iter().map(|value| if sum > 0.0 { value / sum } else { each }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DISPLAY: PixelWindow = PixelWindow { x: -5, y: 3, width: 200, height: 121 };

    #[test]
    fn every_draw_meets_a_tile_and_all_chances_are_one() {
        let expected = Plane::from_fn(DISPLAY, |x, y| if (x + y) % 40 < 3 { 0.2 } else { 0.001 });
        let spots = drawn(&expected);
        assert_eq!(spots.iter().map(|spot| spot.hits).sum::<usize>(), DRAWS[0]);
        assert!(spots.iter().all(|spot| DISPLAY.contains_window(&spot.tile) && spot.chance > 0.0));
        let nothing = drawn(&Plane::filled(DISPLAY, 0.0));
        assert_eq!(nothing.iter().map(|spot| spot.hits).sum::<usize>(), DRAWS[0]);
    }

    #[test]
    fn tiles_that_are_expected_wrong_are_drawn_more_often_and_count_less() {
        let expected = Plane::from_fn(DISPLAY, |x, _| if x < 27 { 0.1 } else { 0.01 });
        let spots = drawn(&expected);
        let left = spots.iter().filter(|spot| spot.tile.x < 27).map(|spot| spot.hits).sum::<usize>();
        assert!(left > DRAWS[0] / 2, "{left} of {} draws in two of thirteen columns", DRAWS[0]);
        // What each stands for adds up to the picture, about: the estimate of 1 is 1
        let area: f64 = spots.iter().map(|spot| spot.hits as f64 * spot.tile.area() as f64 / spot.chance).sum::<f64>();
        let share = area / (DRAWS[0] * DISPLAY.area()) as f64;
        assert!((0.6..1.6).contains(&share), "{share}");
    }
}
