//! A guard around the decoder of EXR files, which panics on some damaged ones.

use std::panic::{AssertUnwindSafe, catch_unwind};

use exr::error::{Error, Result};

/// Runs a piece of the decoder; a panic in it is an error of the file.
///
/// The decoder (exr 1.74) subtracts below zero and slices beyond the end where B44 blocks are spoilt. Nothing that it was
/// working on is used after that.
pub(crate) fn guarded<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| Err(Error::Invalid("nothing that can be decoded".into())))
}
