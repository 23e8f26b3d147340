//! Tilt-shift depth of field.
pub use {compare, filter, optics, rgbd, trace};
