"""NC programs: read, run to a tool path, check, edit by span, write."""
