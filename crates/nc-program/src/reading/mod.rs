//! Bytes become blocks and words, which stay spans of them.

pub(crate) mod letters;
pub(crate) mod lex;
pub(crate) mod lex_names;
pub(crate) mod names;
pub mod number;
pub(crate) mod program;
pub(crate) mod scan;
pub(crate) mod statement;
