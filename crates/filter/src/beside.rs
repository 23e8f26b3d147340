//! What pixels hold beside their first surface, in layers, of which most pixels have none.

use crate::{fragment::Fragment, surface::Surface};

/// The fragments of all pixels: those behind the first surface, nearest first, then one before it.
///
/// The k-th piece behind the first surface lies in layer k, what lies before in the last one; so neighbouring pieces of one
/// surface mostly lie in one layer.
pub(crate) struct Beside {
    fragments: Vec<Fragment>,
    layers: Vec<u16>,
    /// Where the fragments of each pixel start, and where the last one's end.
    starts: Vec<u32>,
}

impl Beside {
    /// From the fragments of the pixels of the `first` surface, pixel by pixel.
    ///
    /// What is nearer than the first surface but no near part of a silhouette contradicts the picture and is left out.
    pub(crate) fn new(first: &Surface, mut fragments: Vec<Fragment>) -> Self {
        let is_farther = |f: &Fragment| f.inverse_depth <= first.inverse_depth[f.index as usize];
        let mut last_before = None;
        fragments.retain(|f| {
            let is_before = !is_farther(f) && f.is_before && last_before != Some(f.index);
            last_before = if is_before { Some(f.index) } else { last_before };
            is_farther(f) || is_before
        });
        for of_pixel in fragments.chunk_by_mut(|a, b| a.index == b.index) {
            let from_near = |a: &Fragment, b: &Fragment| b.inverse_depth.total_cmp(&a.inverse_depth);
            of_pixel.sort_by(|a, b| is_farther(b).cmp(&is_farther(a)).then_with(|| from_near(a, b)));
        }

        let mut layers: Vec<u16> = Vec::with_capacity(fragments.len());
        for of_pixel in fragments.chunk_by(|a, b| a.index == b.index) {
            let behind = (1_u16..u16::MAX - 1).zip(of_pixel).map(|(k, f)| if is_farther(f) { k } else { u16::MAX });
            layers.extend(behind.chain(std::iter::repeat(u16::MAX - 1)).take(of_pixel.len()));
        }
        let mut starts = Vec::with_capacity(first.cover.len() + 1);
        let mut next = 0;
        for i in 0..=first.cover.len() {
            while fragments.get(next).is_some_and(|f| (f.index as usize) < i) {
                next += 1;
            }
            starts.push(next as u32);
        }
        Self { fragments, layers, starts }
    }

    pub(crate) fn fragments(&self) -> &[Fragment] {
        &self.fragments
    }

    /// The layer of a fragment, 1 or more.
    #[inline(always)]
    pub(crate) fn layer(&self, fragment: usize) -> u16 {
        self.layers[fragment]
    }

    /// The fragments of a pixel.
    #[inline(always)]
    pub(crate) fn of_pixel(&self, index: usize) -> std::ops::Range<usize> {
        self.starts[index] as usize..self.starts[index + 1] as usize
    }

    /// The fragment of a pixel in a layer.
    #[inline(always)]
    pub(crate) fn in_layer(&self, index: usize, layer: u16) -> Option<usize> {
        self.of_pixel(index).find(|&i| self.layers[i] == layer)
    }
}
