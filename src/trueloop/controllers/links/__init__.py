"""Links to controls (DNC): programs listed, read, compared and written, each write read back before it counts."""
