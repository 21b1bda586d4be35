//! What a block asks for, and what stays in force from block to block.

pub(crate) mod codes;
pub(crate) mod contradiction;
pub(crate) mod frame;
pub(crate) mod frame_names;
pub(crate) mod gather;
pub(crate) mod home;
pub(crate) mod linear;
pub(crate) mod modal;
pub(crate) mod request;
pub(crate) mod rotary;
pub(crate) mod scaled_frame;
pub(crate) mod setting;
pub(crate) mod state;
pub(crate) mod tool;
pub(crate) mod tool_offset;
pub(crate) mod turned_frame;
pub(crate) mod unit;
