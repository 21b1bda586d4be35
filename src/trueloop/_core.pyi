"""The Rust core, as Python sees it. Checked against the built module by a test."""
