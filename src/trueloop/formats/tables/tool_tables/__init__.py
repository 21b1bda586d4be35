"""Tool tables of controls: read, and written back with single numbers changed."""
