//! Placeholder, replaced with the first module.
