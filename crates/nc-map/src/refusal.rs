//! Why a program is not mapped.

use std::error::Error;

/// A block to which the field cannot be applied.
pub const MAP: &str = "NC-MAP";
/// A position for which the field has no displacement.
pub const FIELD: &str = "NC-FIELD";
/// A displacement larger than the limit.
pub const SIZE: &str = "CMP-SIZE";
/// A displacement that changes more steeply than the limit.
pub const SLOPE: &str = "CMP-SLOPE";

/// What was wrong, at which line and column (from 1).
#[derive(Debug)]
pub struct Refusal {
    /// Code of the error catalogue.
    pub code: &'static str,
    /// What is wrong, with values.
    pub message: String,
    /// How to mend it.
    pub hint: String,
    /// Line of the whole program.
    pub line: usize,
    /// Column.
    pub column: usize,
    /// What the field failed with, when it did.
    pub cause: Option<Box<dyn Error + Send + Sync>>,
}

/// The same, by the byte of the part of the program at hand.
#[derive(Debug)]
pub(crate) struct Refused {
    pub code: &'static str,
    pub message: String,
    pub hint: String,
    pub at: usize,
    pub cause: Option<Box<dyn Error + Send + Sync>>,
}

impl Refused {
    pub fn new(code: &'static str, at: usize, message: String, hint: &str) -> Self {
        Self { code, message, hint: hint.to_owned(), at, cause: None }
    }

    /// A block to which the field cannot be applied.
    pub fn block(at: usize, message: String, hint: &str) -> Self {
        Self::new(MAP, at, message, hint)
    }
}
