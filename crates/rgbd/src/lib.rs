//! The frame: RGB-D pictures with layers, windows and a camera, and the files they live in.
//!
//! One picture type crosses crate borders, the [`Frame`]: colour and depth in layers, nearest first. A result without
//! depth is a [`Picture`]; a traced ground truth with its own noise is a [`Truth`].
//!
//! [`write_frame`], [`write_picture`] and [`write_truth`] make OpenEXR files that [`read_frame`], [`read_picture`] and
//! [`read_truth`] give back bit for bit. The readers also take other programs' files: the header is surveyed, a
//! [`Choice`] of channels is made that says why, and what they hold is brought to this crate's conventions; deep pixels
//! become layers. [`inspect`] tells all of that without making a frame.
//!
//! ```
//! use rgbd::{Frame, Layer, Picture, PixelWindow, Plane, ReadOptions, WriteOptions, read_frame, write_frame};
//!
//! let window = PixelWindow::of_size(64, 36);
//! let ramp = Plane::from_fn(window, |x, _| if x < 60 { 1.0 + x as f32 } else { f32::INFINITY });
//! let frame = Frame::new(window, vec![Layer::from_raw_depth(Picture::filled(window, [0.18, 0.18, 0.18, 1.0]), ramp)])?;
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("ramp.exr");
//! write_frame(&path, &frame, &WriteOptions::default())?;
//! let read = read_frame(&path, &ReadOptions::default())?;
//! assert_eq!(read.value, frame);
//! println!("{}", read.choice); // colour from R, G, B, A; depth from Z (the file says so itself)
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What our files hold
//!
//! One part of scan lines, all channels f32. Depth is planar, `+inf` for the sky, NaN where it is not known.
//!
//! | attribute | type | holds |
//! | --- | --- | --- |
//! | `tiltshift.kind` | string | `frame`, `picture` or `truth` |
//! | `tiltshift.layers` | int | number of layers: `R G B A Z`, `L2.R` ... `L2.Z`, and on; other channels are planes |
//! | `tiltshift.samples` | string | samples per pixel in `half0.*` and `half1.*` of a truth |
//! | `tiltshift.camera` | string | the camera as JSON; each number gives back its f64 exactly |
//! | `tiltshift.metresPerUnit` | double | metres in one unit of depth |
//! | `tiltshift.note.NAME` | string | free text |
//!
//! Beside them stand the standard `worldToCamera` and `worldToNDC` where there is a camera, `chromaticities`,
//! `pixelAspectRatio`, and what [`LensAttributes`] names.

mod attributes;
mod camera_text;
mod channel_name;
mod choice;
mod choose;
mod choose_color;
mod choose_depth;
mod compression;
mod convert;
mod deep;
mod depth_convention;
mod depth_map;
mod depth_summary;
mod detect;
mod encode_exr;
mod exr_file;
mod flat_blocks;
mod foreign_start;
mod frame;
mod guard;
mod head;
mod headers;
mod inspect;
mod lens_attributes;
mod offset_table;
mod optical_depth;
mod photo;
mod picture;
mod pixel_window;
mod plane;
mod png;
mod primaries;
mod progress;
mod read;
mod read_error;
mod read_options;
mod replace;
mod rest;
mod survey;
mod truth;
mod write;
mod write_error;

pub use choice::Choice;
pub use compression::Compression;
pub use deep::DeepTally;
pub use depth_convention::DepthConvention;
pub use depth_map::{DepthMap, MapMeaning, fill_holes, fit_to_picture, read_depth_map};
pub use depth_summary::DepthSummary;
pub use detect::DepthVerdict;
pub use frame::{Frame, FrameError, Layer};
pub use head::Head;
pub use inspect::{Inspection, Understood, inspect};
pub use lens_attributes::LensAttributes;
pub use photo::{Encoding, Photo, PhotoFormat, SampleDepth, photo_size, read_photo, write_photo};
pub use picture::Picture;
pub use pixel_window::PixelWindow;
pub use plane::{Mask, Plane};
pub use png::{encode_png, srgb_byte, write_png};
pub use primaries::Primaries;
pub use progress::{Cancelled, Progress, Silent};
pub use read::{Loaded, read_frame, read_picture, read_planes, read_truth, survey_file};
pub use read_error::ReadError;
pub use read_options::ReadOptions;
pub use replace::{could_replace_file, replace_file};
pub use rest::{PixelRest, Rest};
pub use survey::{ChannelSurvey, PartSurvey, SampleKind, Survey};
pub use truth::Truth;
pub use write::{Notes, WriteOptions, write_frame, write_picture, write_picture_with, write_truth};
pub use write_error::WriteError;
