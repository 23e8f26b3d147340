//! Focus as a wish: a band of the picture, the ground, a miniature.

use std::str::FromStr;

use anyhow::{anyhow, bail};
use clap::ValueEnum;
use glam::DVec2;
use optics::{Film, Focus, Ground, ThinLens};

use crate::values::Pixel;

/// What there is to see where focus is chosen.
pub(crate) trait Seen {
    /// Depth in metres of what a pixel shows.
    fn depth_at(&self, pixel: Pixel) -> anyhow::Result<f64>;

    /// Inverse depths per metre (0 for the sky) of the known pixels of a row of the picture; `None` where there is no picture.
    fn row(&self, row: i32) -> Option<Vec<(Pixel, f64)>>;

    /// The ground, where it is known already; else it is found in this picture.
    fn ground(&self) -> Option<Ground> {
        None
    }

    /// Takes a line for the user.
    fn say(&self, line: std::fmt::Arguments<'_>);
}

/// What to lay the plane of focus by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FocusWish {
    /// Along the ground: sharp from near to far.
    Ground,
    /// Upright on the ground: a sharp strip.
    Miniature,
}

/// Two rows of the picture, from the top.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Band([i32; 2]);

impl FromStr for Band {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        // Two rows are written as a pixel is
        let Pixel { x, y } = text.parse()?;
        if x == y { bail!("both rows are the same") } else { Ok(Self([x.min(y), x.max(y)])) }
    }
}

/// Circle of confusion at the borders of a band, in pixels of radius: what counts as sharp.
const BAND_RADIUS_PX: f64 = 1.0;

impl Band {
    /// The lens focused so that both borders of the band are off by the same, the aperture too where it `opens`.
    ///
    /// With the stand of the lens fixed, w_xy is n_xy/F, and w_z is the middle of 1/z - w_xy.q at the two rows.
    pub(crate) fn focused(self, lens: ThinLens, film: &Film, seen: &dyn Seen, opens: bool) -> anyhow::Result<ThinLens> {
        let w_xy = lens.focus().w().truncate();
        let defocus = |row: i32| {
            let inverse = median_inverse(seen, row, film.height())?;
            let middle = DVec2::new(0.5 * f64::from(film.width()), f64::from(row) + 0.5);
            anyhow::Ok(inverse - w_xy.dot(film.q_from_pixel(middle)))
        };
        let [a, b] = [defocus(self.0[0])?, defocus(self.0[1])?];
        let (w_z, delta) = (0.5 * (a + b), 0.5 * (a - b).abs());

        // n_z/F - 1/v = w_z
        let inverse_v = lens.axis().z / lens.focal_length() - w_z;
        if !(inverse_v > 0.0 && inverse_v.is_finite()) {
            bail!("the band lies too near for this lens to focus on; choose rows that show something farther away");
        }
        let lens = lens.with_image_distance(inverse_v.recip())?;
        if !opens {
            return Ok(lens);
        }
        if delta <= 1e-9 * w_z.abs() {
            bail!(
                "both rows of the band are equally far from the plane of focus; choose rows at different depths, or give --f-number"
            );
        }
        let radius = BAND_RADIUS_PX / (delta * film.pixels_per_q().max_element());
        let lens = lens.with_aperture_radius(radius)?;
        seen.say(format_args!("the band takes f/{:.3}", lens.f_number()));
        Ok(lens)
    }
}

/// The median of the inverse depths of a row.
fn median_inverse(seen: &dyn Seen, row: i32, height: u32) -> anyhow::Result<f64> {
    if !u32::try_from(row).is_ok_and(|row| row < height) {
        bail!("row {row} is outside the picture of {height} rows");
    }
    let pixels = seen.row(row).ok_or_else(|| anyhow!("there is no picture here to take the depths of a row from"))?;
    let mut inverse: Vec<f64> = pixels.into_iter().map(|(_, inverse)| inverse).collect();
    inverse.sort_by(f64::total_cmp);
    inverse.get(inverse.len() / 2).copied().ok_or_else(|| anyhow!("no depth is known in row {row}; choose another"))
}

/// About so many pixels are looked at to find the ground.
const SAMPLES: u32 = 20_000;

/// The ground in the depths of one picture.
pub(crate) fn find_ground(film: &Film, seen: &dyn Seen) -> anyhow::Result<Ground> {
    // Look at every so many rows and columns
    let area = u64::from(film.width()) * u64::from(film.height());
    let step = (area as f64 / f64::from(SAMPLES)).sqrt().ceil().max(1.0) as usize;
    let mut samples = Vec::new();
    for row in (0..film.height() as i32).step_by(step) {
        let pixels = seen.row(row).ok_or_else(|| anyhow!("there is no picture here to find the ground in"))?;
        let pixels = pixels.into_iter().filter(|(pixel, _)| (pixel.x as usize).is_multiple_of(step));
        samples.extend(pixels.map(|(pixel, inverse)| (film.q_from_pixel(pixel.center()), inverse)));
    }
    Ground::find(&samples).ok_or_else(|| {
        anyhow!(
            "no ground was found in the depth: no plane below the camera holds a tenth of the picture; lay the plane of focus \
             with --focus-points or --focus-plane"
        )
    })
}

/// The plane of focus along the ground, or upright on it through a pixel: the middle of the picture without, and where the ground
/// is known already, what it has there, so that nothing that passes by moves the focus.
pub(crate) fn ground_plane(
    wish: FocusWish,
    pixel: Option<Pixel>,
    film: &Film,
    seen: &dyn Seen,
) -> anyhow::Result<Focus> {
    let known = seen.ground();
    let ground = match known {
        Some(ground) => ground,
        None => {
            let ground = find_ground(film, seen)?;
            let share = 100.0 * ground.share();
            seen.say(format_args!(
                "ground found in {share:.0} % of the picture, {:.4} m below the lens",
                ground.height()
            ));
            ground
        }
    };
    match wish {
        FocusWish::Ground => Ok(ground.plane()),
        FocusWish::Miniature => {
            let middle = Pixel { x: film.width() as i32 / 2, y: film.height() as i32 / 2 };
            let at = pixel.unwrap_or(middle);
            let q = film.q_from_pixel(at.center());
            let of_ground = || ground.plane().depth(q);
            let depth = match (known, pixel) {
                (Some(_), None) => of_ground().unwrap_or(f64::INFINITY),
                _ => seen.depth_at(at)?,
            };
            if !depth.is_finite() {
                bail!("pixel {at} shows the sky; name one of the ground or of a thing with --focus-pixel");
            }
            Ok(ground.standing_at(q, depth)?)
        }
    }
}
