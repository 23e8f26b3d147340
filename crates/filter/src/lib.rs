//! Depth of field as a post-process: RGB-D frame and camera to defocused picture.
