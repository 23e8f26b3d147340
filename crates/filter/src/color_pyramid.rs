//! The first surface at a half, a quarter, ... of its resolution, in planes.

use rayon::prelude::*;
use rgbd::PixelWindow;

use crate::surface::finite;

/// A level: cells of `side` pixels, anchored at pixel (0, 0).
pub(crate) struct ColorLevel {
    /// The cells, in units of cells.
    pub(crate) window: PixelWindow,
    pub(crate) inverse_depth: Vec<f32>,
    /// The share of the cell that lies inside the data.
    pub(crate) cover: Vec<f32>,
    /// Mean over that share.
    pub(crate) rgba: [Vec<f32>; 4],
}

/// A row of a level: inverse depth, cover, colour.
type Row<'a> = (&'a [f32], Option<&'a [f32]>, [&'a [f32]; 4]);

impl ColorLevel {
    /// The next coarser level of a `window` whose rows are `row`.
    pub(crate) fn halved<'a>(window: PixelWindow, row: impl Fn(i32) -> Row<'a> + Sync) -> Self {
        let halved = PixelWindow::from_corners(
            window.x.div_euclid(2),
            window.y.div_euclid(2),
            (window.x_end() + 1).div_euclid(2),
            (window.y_end() + 1).div_euclid(2),
        );
        let width = halved.width as usize;
        let plane = || vec![0.0; halved.area()];
        let mut level =
            Self { window: halved, inverse_depth: plane(), cover: plane(), rgba: [plane(), plane(), plane(), plane()] };
        let [r, g, b, a] = &mut level.rgba;
        let rows = level.inverse_depth.par_chunks_mut(width).zip(level.cover.par_chunks_mut(width));
        let colors = r.par_chunks_mut(width).zip(g.par_chunks_mut(width)).zip(b.par_chunks_mut(width));
        let rows = rows.zip(colors.zip(a.par_chunks_mut(width))).enumerate();
        rows.for_each(|(j, ((inverse_depth, cover), (((r, g), b), a)))| {
            let top = 2 * (halved.y + j as i32);
            let out = [inverse_depth, r, g, b, a];
            let rows: Vec<Row> = (top.max(window.y)..(top + 2).min(window.y_end())).map(&row).collect();
            average(&rows, window, out, cover);
        });
        level
    }

    /// Its row at `y`.
    pub(crate) fn row(&self, y: i32) -> Row<'_> {
        let width = self.window.width as usize;
        let start = (y - self.window.y) as usize * width;
        let part = start..start + width;
        let [r, g, b, a] = &self.rgba;
        let rgba = [r, g, b, a].map(|plane| &plane[part.clone()]);
        (&self.inverse_depth[part.clone()], Some(&self.cover[part]), rgba)
    }
}

/// Averages one or two rows over pairs of columns, each pixel by its share of the data.
fn average(rows: &[Row], window: PixelWindow, out: [&mut [f32]; 5], cover: &mut [f32]) {
    let width = window.width as usize;
    let shift = window.x.rem_euclid(2) as usize;
    let plane = |row: &Row<'_>, k: usize, x: usize| if k == 0 { row.0[x] } else { finite(row.2[k - 1][x]) };
    let share = |row: &Row<'_>, x: usize| row.1.map_or(1.0, |cover| cover[x]);

    // Cells whose four pixels are all there are plain means
    let is_whole = rows.len() == 2 && rows.iter().all(|row| row.1.is_none_or(|cover| cover.iter().all(|&c| c == 1.0)));
    let inner = if is_whole { shift..shift + (width - shift) / 2 } else { 0..0 };
    let border = (0..inner.start).chain(inner.end..cover.len());
    let [s, r, g, b, a] = out;
    if let [upper, lower] = rows {
        cover[inner.clone()].fill(1.0);
        let color =
            [(&mut *r, 0), (&mut *g, 1), (&mut *b, 2), (&mut *a, 3)].map(|(out, c)| (out, upper.2[c], lower.2[c]));
        for (out, upper, lower) in std::iter::once((&mut *s, upper.0, lower.0)).chain(color) {
            let pairs = upper[shift..].chunks_exact(2).zip(lower[shift..].chunks_exact(2));
            for (out, (upper, lower)) in out[inner.clone()].iter_mut().zip(pairs) {
                *out = 0.25 * (finite(upper[0]) + finite(upper[1]) + finite(lower[0]) + finite(lower[1]));
            }
        }
    }

    for i in border {
        let columns = (2 * i).saturating_sub(shift)..(2 * i + 2 - shift).min(width);
        let total: f32 = rows.iter().flat_map(|row| columns.clone().map(|x| share(row, x))).sum();
        cover[i] = 0.25 * total;
        for (k, out) in [&mut *s, &mut *r, &mut *g, &mut *b, &mut *a].into_iter().enumerate() {
            let parts = rows.iter().flat_map(|row| columns.clone().map(|x| share(row, x) * plane(row, k, x)));
            out[i] = if total > 0.0 { parts.sum::<f32>() / total } else { 0.0 };
        }
    }
}
