"""Where to touch, what a touch on the machine means: plans, obstacles, stylus, calibration."""
