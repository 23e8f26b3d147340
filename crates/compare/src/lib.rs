//! Two pictures to error figures, masks, heat maps and a report page.

mod comparison;
mod convolve;
mod error;
mod figures;
mod flip_color;
mod flip_hdr;
mod flip_ldr;
mod masks;
mod noise;
mod reference;
mod rgb;
mod ssim;
mod transfer;

pub use comparison::Comparison;
pub use error::CompareError;
pub use figures::Figures;
pub use flip_hdr::Exposures;
pub use flip_ldr::PIXELS_PER_DEGREE;
pub use masks::{EDGE_JUMP_PX, LEAST_REACH_PX, MaskKind, Masks};
pub use noise::{CorrectedError, GivenNoise, psnr_db};
pub use reference::Reference;
