//! A borrowed part of a frame.

use rgbd::{Frame, PixelWindow};

/// A frame of which only a window may be read: what a band of a larger picture is filtered from.
#[derive(Debug, Clone, Copy)]
pub struct FrameView<'a> {
    frame: &'a Frame,
    window: PixelWindow,
}

impl<'a> FrameView<'a> {
    /// All of a frame.
    #[must_use]
    pub fn whole(frame: &'a Frame) -> Self {
        Self { frame, window: frame.data() }
    }

    /// The part of a frame inside `window`.
    #[must_use]
    pub fn part(frame: &'a Frame, window: PixelWindow) -> Self {
        Self { frame, window: frame.data().intersection(&window) }
    }

    /// The frame behind the view.
    #[must_use]
    pub fn frame(&self) -> &'a Frame {
        self.frame
    }

    /// The pixels that may be read.
    #[must_use]
    pub fn window(&self) -> PixelWindow {
        self.window
    }
}
