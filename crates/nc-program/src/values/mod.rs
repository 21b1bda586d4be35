//! What a word is worth: expressions, functions, parameters of the program and of the machine.

pub(crate) mod asked;
pub(crate) mod expression;
pub(crate) mod functions;
pub(crate) mod operand;
pub(crate) mod parameters;
pub(crate) mod scope;
pub(crate) mod uses;
