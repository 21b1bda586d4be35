"""Files of the real-time loop: images, and samples of a run."""
