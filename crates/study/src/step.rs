//! One of many equal steps, told to the progress of the whole.

use rgbd::Progress;

/// The progress of step `index` of `count`.
pub(crate) struct Step<'a> {
    pub(crate) whole: &'a dyn Progress,
    pub(crate) index: usize,
    pub(crate) count: usize,
}

/// Parts that a step is told in.
const PARTS: u64 = 1000;

impl Progress for Step<'_> {
    fn report(&self, done: u64, total: u64) {
        self.whole.report(PARTS * self.index as u64 + PARTS * done / total.max(1), PARTS * self.count as u64);
    }

    fn is_cancelled(&self) -> bool {
        self.whole.is_cancelled()
    }
}
