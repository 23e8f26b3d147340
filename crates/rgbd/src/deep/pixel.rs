//! One deep pixel: samples into surfaces.

/// Depths of one surface are larger than that of its nearest sample by at most this share.
const SAME_SURFACE: f32 = 0.01;

/// A piece of something that a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    /// Planar depth, NaN where it is not known.
    pub(crate) depth: f32,
    /// Premultiplied colour and alpha.
    pub(crate) rgba: [f32; 4],
}

/// What a pixel becomes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Surfaces {
    /// The flattened colour at the depth of the surface at which the opacity passes half.
    pub(crate) front: Sample,
    /// What lies behind that surface, nearest first.
    pub(crate) hidden: Vec<Sample>,
}

impl Surfaces {
    /// Sorts the samples and makes surfaces of them; `None` where there are none.
    pub(crate) fn of(samples: &mut Vec<Sample>) -> Option<Self> {
        // An unknown depth is behind all known ones
        samples.sort_by(|a, b| a.depth.is_nan().cmp(&b.depth.is_nan()).then(a.depth.total_cmp(&b.depth)));

        // Samples near to each other are one surface
        let mut surfaces: Vec<Sample> = Vec::new();
        for sample in samples.drain(..) {
            // The sky goes on as the sky; an unknown depth with nothing
            let goes_on = |near: f32| sample.depth == near || sample.depth - near <= SAME_SURFACE * near;
            match surfaces.last_mut() {
                Some(surface) if goes_on(surface.depth) => surface.rgba = over(surface.rgba, sample.rgba),
                _ => surfaces.push(sample),
            }
        }
        if surfaces.is_empty() {
            return None;
        }

        // Find the surface that fills most of the pixel
        let half = 0.5 * flatten(&surfaces)[3];
        let mut seen = [0.0; 4];
        let front = surfaces.iter().position(|surface| {
            seen = over(seen, surface.rgba);
            seen[3] >= half
        });
        let front = front.unwrap_or(0);
        let hidden = surfaces[front + 1..].iter().filter(|surface| surface.rgba[3] > 0.0).copied().collect();
        Some(Self { front: Sample { depth: surfaces[front].depth, rgba: flatten(&surfaces) }, hidden })
    }

    /// Lays all hidden surfaces from the `most`th on over each other; says whether there was something to do.
    pub(crate) fn merge_beyond(&mut self, most: usize) -> bool {
        let is_more = self.hidden.len() > most;
        if is_more {
            self.hidden[most - 1].rgba = flatten(&self.hidden[most - 1..]);
            self.hidden.truncate(most);
        }
        is_more
    }
}

/// All surfaces, nearest first, laid over each other.
fn flatten(surfaces: &[Sample]) -> [f32; 4] {
    surfaces.iter().fold([0.0; 4], |above, surface| over(above, surface.rgba))
}

/// Porter and Duff's *over* (1984) of premultiplied colours: `above + (1 - alpha of above) below`.
fn over(above: [f32; 4], below: [f32; 4]) -> [f32; 4] {
    let open = (1.0 - above[3]).max(0.0);
    [0, 1, 2, 3].map(|c| above[c] + open * below[c])
}
