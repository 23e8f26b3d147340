//! `tiltshift lens`.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {}
pub(crate) fn run(_: &Options) -> crate::failure::Outcome {
    Ok(())
}
