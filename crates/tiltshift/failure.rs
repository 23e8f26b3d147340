//! How a command ends when it does not end well, and the exit code that says so.

use std::process::ExitCode;

/// Why a command did not do all that was asked.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Bad input or usage: exit code 2.
    Input(anyhow::Error),
    /// A threshold was exceeded: exit code 1.
    Exceeded(String),
    /// Stopped by the user: exit code 130.
    Interrupted,
}

/// What commands return.
pub(crate) type Outcome = Result<(), Failure>;

impl Failure {
    /// The exit code that scripts see.
    pub(crate) fn exit_code(&self) -> ExitCode {
        match self {
            Self::Exceeded(_) => ExitCode::from(1),
            Self::Input(_) => ExitCode::from(2),
            Self::Interrupted => ExitCode::from(130),
        }
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Input(error) => {
                // What failed, then why, unless that was said already
                let mut said = error.to_string();
                for cause in error.chain().skip(1).map(ToString::to_string) {
                    if !said.contains(cause.trim()) {
                        said = format!("{said}: {cause}");
                    }
                }
                f.write_str(said.trim_end())
            }
            Self::Exceeded(what) => f.write_str(what),
            Self::Interrupted => f.write_str("stopped; no result was written that is not complete"),
        }
    }
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Input(error)
    }
}

/// Library errors are bad input; that a stage was cancelled is noticed where commands end.
macro_rules! input_errors {
    ($($error:ty),*) => {$(
        impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                anyhow::Error::new(error).into()
            }
        }
    )*};
}

input_errors!(
    compare::CompareError,
    filter::FilterError,
    optics::OpticsError,
    rgbd::ReadError,
    rgbd::WriteError,
    study::StudyError,
    trace::FileError,
    trace::PartError,
    trace::RenderError
);
