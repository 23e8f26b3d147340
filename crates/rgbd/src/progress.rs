//! How long work tells where it stands, and learns that it should stop.

use thiserror::Error;

/// What long work reports to and asks; called from many threads.
pub trait Progress: Sync {
    /// `done` of `total` equal steps are finished. Calls may come out of order.
    fn report(&self, done: u64, total: u64);

    /// Whether the work should stop soon; it then returns [`Cancelled`].
    fn is_cancelled(&self) -> bool {
        false
    }
}

/// No progress, never cancelled.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _done: u64, _total: u64) {}
}

/// The work was stopped from outside; nothing it made may be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("stopped before it was finished")]
pub struct Cancelled;
