//! From the programmed contour to the path of the tool's centre.

pub(crate) mod compensate;
pub(crate) mod corner;
pub(crate) mod entry;
pub(crate) mod offset;
