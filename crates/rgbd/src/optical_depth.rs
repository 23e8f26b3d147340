//! How far away what mirrors and glass show seems to be.

use crate::{Frame, Plane};

/// Name of the plane of a frame that holds it.
const NAME: &str = "optical.Z";

impl Frame {
    /// The planar depth at which what each pixel of the first layer shows would be sharp, where the frame knows it.
    ///
    /// On a mirror or glass that is the depth of the image in it, elsewhere that of the surface; +inf where the image is
    /// infinitely far. What is not in (0, +inf] says nothing.
    #[must_use]
    pub fn optical_depth(&self) -> Option<&Plane> {
        self.planes.get(NAME)
    }

    /// The same frame that knows it.
    #[must_use]
    pub fn with_optical_depth(mut self, depth: Plane) -> Self {
        self.planes.insert(NAME.to_owned(), depth);
        self
    }

    /// The same frame that does not know it.
    #[must_use]
    pub fn without_optical_depth(mut self) -> Self {
        self.planes.remove(NAME);
        self
    }
}
