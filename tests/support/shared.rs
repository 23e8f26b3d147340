//! The folder of reference pictures and foreign files, where there is one.

use std::path::PathBuf;

/// The folder that `TILTSHIFT_SHARED` names; `None`, said aloud, where it is unset.
///
/// A variable that names no folder is a mistake, and fails.
#[expect(clippy::print_stderr, reason = "a test that is skipped must say so")]
pub(crate) fn folder() -> Option<PathBuf> {
    let Some(root) = std::env::var_os("TILTSHIFT_SHARED") else {
        eprintln!("skipped: TILTSHIFT_SHARED is not set");
        return None;
    };
    let root = PathBuf::from(root);
    assert!(root.is_dir(), "TILTSHIFT_SHARED names {}, which is no folder", root.display());
    Some(root)
}
