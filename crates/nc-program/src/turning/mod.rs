//! Cycles of lathes: roughing, finishing, grooves, threads.

pub(crate) mod beside;
pub(crate) mod groove;
pub(crate) mod lap;
pub(crate) mod level_cuts;
pub(crate) mod own_cycle;
pub(crate) mod pass;
pub(crate) mod profile_contour;
pub(crate) mod profile_cycle;
pub(crate) mod removal;
pub(crate) mod removal_cuts;
pub(crate) mod rough;
pub(crate) mod rough_contour;
pub(crate) mod rough_cycle;
pub(crate) mod rough_pockets;
pub(crate) mod segment;
pub(crate) mod thread;
pub(crate) mod thread_cycle;
