//! The only place that talks to the terminal while work goes on: messages, progress bars, Ctrl-C.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

use indicatif::{ProgressBar, ProgressStyle};
use rgbd::Progress;

/// Set once a result could not be written to stdout.
static STDOUT_FAILED: AtomicBool = AtomicBool::new(false);

/// Set once Ctrl-C was pressed.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Makes the first Ctrl-C stop the work cleanly and a second one end the program at once.
pub(crate) fn listen_for_interrupts() {
    // Without a handler Ctrl-C still ends the program, only less tidily
    let _ = ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    });
}

/// Whether Ctrl-C was pressed.
pub(crate) fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}

/// One line for the user on stderr. A closed stderr is not worth failing for.
pub(crate) fn say(line: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// A line of a command's result on stdout. A reader that went away (`| head`) is not worth failing for.
pub(crate) fn print(line: impl std::fmt::Display) {
    let written = writeln!(std::io::stdout(), "{line}").and_then(|()| std::io::stdout().flush());
    if written.is_err_and(|error| error.kind() != std::io::ErrorKind::BrokenPipe) {
        STDOUT_FAILED.store(true, Ordering::SeqCst);
    }
}

/// Whether a result was lost on its way to stdout.
pub(crate) fn lost_output() -> bool {
    STDOUT_FAILED.load(Ordering::SeqCst)
}

/// A progress bar on the terminal, nothing in a pipe; it also carries Ctrl-C to the work.
pub(crate) struct Bar {
    bar: ProgressBar,
}

impl Bar {
    /// A bar that says what is being done.
    pub(crate) fn new(what: impl Into<std::borrow::Cow<'static, str>>) -> Self {
        let style = ProgressStyle::with_template("{msg:24} {bar:32} {percent:>3} %  {elapsed} (still {eta})");
        let bar = ProgressBar::new(0).with_message(what);
        if let Ok(style) = style {
            bar.set_style(style);
        }
        Self { bar }
    }
}

/// Nothing to see; it only carries Ctrl-C to the work.
pub(crate) struct Unseen;

impl Progress for Unseen {
    fn report(&self, _: u64, _: u64) {}

    fn is_cancelled(&self) -> bool {
        is_interrupted()
    }
}

impl Progress for Bar {
    fn report(&self, done: u64, total: u64) {
        self.bar.set_length(total);
        self.bar.set_position(done);
    }

    fn is_cancelled(&self) -> bool {
        is_interrupted()
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
