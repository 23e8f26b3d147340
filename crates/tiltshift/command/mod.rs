//! One file per subcommand.

pub(crate) mod advise;
pub(crate) mod benchmark;
pub(crate) mod causes;
pub(crate) mod chart;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod demo;
pub(crate) mod filter;
pub(crate) mod hybrid;
pub(crate) mod info;
pub(crate) mod lens;
pub(crate) mod man;
pub(crate) mod merge;
pub(crate) mod render;
pub(crate) mod stability;
