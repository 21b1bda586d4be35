"""`trueloop compensate`, `demo` and `part`: a turned part."""
