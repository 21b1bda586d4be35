"""MTConnect: an adapter that tells agents what LinuxCNC does, and a reader of what agents hold."""
