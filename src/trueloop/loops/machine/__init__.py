"""Programs and points displaced by a model or a field of the machine."""
