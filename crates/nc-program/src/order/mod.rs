//! Which block comes next: jumps, loops, calls.

pub(crate) mod endless;
pub(crate) mod flow;
pub(crate) mod follow;
pub(crate) mod labels;
pub(crate) mod macro_call;
pub(crate) mod macros;
pub(crate) mod sections;
pub(crate) mod structured;
pub(crate) mod visit;
