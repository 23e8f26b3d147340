//! Tilt-shift depth of field, in parts that only make sense together.
//!
//! * [`trace`]: a distributed ray tracer whose lens really tilts, swings and shifts: the ground truth, and RGB-D frames;
//! * [`filter`]: the same lens put onto any renderer's RGB-D picture, with a circle of confusion per pixel from the
//!   *tilted* plane of focus;
//! * [`compare`]: how far the filter is from the truth, and where;
//! * [`study`]: what each further second buys: all methods by time and error.
//!
//! They share one camera, [`optics`], and one picture, the frame of [`rgbd`]. This package is the command line and
//! re-exports the crates under one roof.

pub use {compare, filter, optics, rgbd, study, trace};
