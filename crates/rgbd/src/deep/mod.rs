//! Deep parts: any number of samples for each pixel, brought to the layers of a frame.
//!
//! A deep pixel is a list of samples with depth and premultiplied colour (*Interpreting OpenEXR Deep Pixels*, Hillman
//! 2013). What becomes of it:
//!
//! * Samples are sorted by planar depth, nearest first. One with a `ZBack` behind its `Z` fills a volume; it is taken as a
//!   sample in the middle of it, which blurs all of it alike. Volumes that overlap are not split.
//! * What lies within 1 % of the depth of the sample before which nothing of it lies is one surface with it, laid over
//!   each other.
//! * The frame's first layer holds the flattened colour, as a flat render of the same thing would, at the depth of the
//!   surface at which the pixel's opacity passes half of what it is in the end: a haze before a wall does not take the
//!   wall's place, and an anti-aliased edge lies where most of it is.
//! * Each surface behind that one is a hidden layer with its own colour and alpha. There are at most [`MOST_LAYERS`]
//!   layers; what lies farther still is laid over each other in the last of them.
//!
//! The decoder of flat parts (exr 1.74) refuses deep ones; from it come the header and the unpacking of bytes.

mod block;
mod chunks;
mod layers;
mod pixel;
mod read;

pub(crate) use read::{DeepFrame, read_deep};

/// The largest number of layers that a deep part makes.
pub(crate) const MOST_LAYERS: usize = 8;

/// What a deep part holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DeepTally {
    /// Samples in all.
    pub samples: u64,
    /// The most samples in one pixel.
    pub most: u64,
    /// Pixels without any.
    pub empty: u64,
    /// Pixels with more surfaces than there are layers: what lies farther is merged into the last one.
    pub merged: u64,
    /// Samples of which `ZBack` lies behind `Z`.
    pub volumes: u64,
}

impl std::fmt::Display for DeepTally {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "deep, up to {} samples a pixel", self.most)?;
        if self.volumes > 0 {
            write!(f, ", {} volumes taken at their middle", self.volumes)?;
        }
        if self.merged > 0 {
            write!(f, ", in {} pixels all beyond layer {MOST_LAYERS} merged into it", self.merged)?;
        }
        Ok(())
    }
}
