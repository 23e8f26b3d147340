//! Two pictures to error figures, masks, heat maps and a report page.
//!
//! A [`Reference`] is a traced [`rgbd::Truth`], whose two halves tell its noise, or any picture, with or without known
//! noise. A [`Comparison`] holds the [`Figures`] of one candidate over [`Masks`]; a [`Report`] lays them out on one
//! self-contained page.
//!
//! ```
//! use compare::{Comparison, CorrectedError, GivenNoise, MaskKind, Masks, Reference};
//! use rgbd::{Picture, PixelWindow};
//!
//! let display = PixelWindow::of_size(16, 9);
//! let reference = Picture::filled(display, [0.5, 0.5, 0.5, 1.0]);
//! let candidate = Picture::filled(display, [0.6, 0.5, 0.5, 1.0]);
//!
//! let noise = GivenNoise { all: Some(1e-6), ..GivenNoise::default() };
//! let reference = Reference::from_picture(&reference, display, noise)?;
//! let comparison = Comparison::new(&reference, &candidate, &Masks::without_depth(display))?;
//!
//! let figures = comparison.all();
//! assert_eq!(figures.mask, MaskKind::All);
//! assert!((figures.mse - 0.01 / 3.0).abs() < 1e-6);
//! assert!(matches!(figures.corrected, CorrectedError::Above { .. }));
//! # Ok::<(), compare::CompareError>(())
//! ```

mod comparison;
mod convolve;
mod error;
mod figures;
mod flip_alone;
mod flip_color;
mod flip_hdr;
mod flip_ldr;
mod heat;
mod interval;
mod masks;
mod noise;
mod png;
mod ramp;
mod reference;
mod report;
mod report_page;
mod report_pictures;
mod report_tables;
mod report_viewer;
mod rgb;
mod ssim;
mod transfer;

pub use comparison::Comparison;
pub use error::CompareError;
pub use figures::{Figures, Intervals};
pub use flip_alone::{flip_hdr_at, mean_flip_hdr};
pub use flip_hdr::Exposures;
pub use flip_ldr::PIXELS_PER_DEGREE;
pub use heat::{HeatKind, round_scale};
pub use interval::Interval;
pub use masks::{EDGE_JUMP_PX, IN_FOCUS_PX, LEAST_REACH_PX, MaskKind, Masks};
pub use noise::{CorrectedError, GivenNoise, psnr_db};
pub use ramp::Ramp;
pub use reference::Reference;
pub use report::{Entry, Parameter, Report};
