//! Which parts of a surface may reach a tile.

use rgbd::PixelWindow;

use crate::surface::Surface;

/// Side of a cell in pixels. Cells only cull: their size and place never change a result.
const CELL: u32 = 8;

/// The range of inverse depth in each 8x8 cell of a surface.
pub(crate) struct Cells {
    columns: usize,
    /// Window, smallest and largest inverse depth; cells that hold nothing are left out.
    cells: Vec<Option<(PixelWindow, f32, f32)>>,
}

impl Cells {
    pub(crate) fn new(surface: &Surface) -> Self {
        let window = surface.window;
        let (columns, rows) = (window.width.div_ceil(CELL), window.height.div_ceil(CELL));
        let cell = |column: u32, row: u32| {
            let corner = PixelWindow {
                x: window.x + (column * CELL) as i32,
                y: window.y + (row * CELL) as i32,
                width: CELL,
                height: CELL,
            };
            let part = corner.intersection(&window);
            let inside = part.pixels().map(|(x, y)| window.index(x, y)).filter(|&i| surface.cover[i] > 0.0);
            let range = inside.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), i| {
                let s = surface.inverse_depth[i];
                (low.min(s), high.max(s))
            });
            (range.0 <= range.1).then_some((part, range.0, range.1))
        };
        let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        Self { columns: columns as usize, cells: cells.map(|(column, row)| cell(column, row)).collect() }
    }

    /// The cells of which a pixel may lie within `reach(smallest, largest inverse depth)` pixels of `tile`.
    pub(crate) fn reaching<'a>(
        &'a self,
        tile: PixelWindow,
        reach: impl Fn(f32, f32) -> f32 + 'a,
    ) -> impl Iterator<Item = PixelWindow> + 'a {
        debug_assert!(self.columns > 0);
        self.cells.iter().flatten().filter_map(move |&(part, low, high)| {
            let gap_x = (tile.x - (part.x_end() - 1)).max(part.x - (tile.x_end() - 1)).max(0) as f32;
            let gap_y = (tile.y - (part.y_end() - 1)).max(part.y - (tile.y_end() - 1)).max(0) as f32;
            let reach = reach(low, high);
            (gap_x * gap_x + gap_y * gap_y <= reach * reach).then_some(part)
        })
    }
}
