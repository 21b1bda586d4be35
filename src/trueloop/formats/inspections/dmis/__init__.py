"""DMIS (ANSI/DMIS 105, ISO 22093): its statements, results read and written, and programs for measuring machines."""
