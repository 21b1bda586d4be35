//! Real-time error correction: what a servo thread adds to the commands of the control, period by period.
//!
//! [`image`] reads and checks what was prepared beforehand; [`wanted`] asks it what should be added at a place;
//! [`corrector`] decides how much of that may be in force: phases, slew, travel, signals that are late or impossible.
//! include/rtec.h is the same for C.

#![no_std]

mod body;
#[cfg(test)]
mod built;
#[cfg(any(feature = "c-library", test))]
pub mod c_api;
pub mod corrector;
pub mod image;
pub mod names;
mod path;
pub mod wanted;
mod words;
