"""Jobs of turned parts: a job file to its correction, and what is begun, listed and entered for it."""
