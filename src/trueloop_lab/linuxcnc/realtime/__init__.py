"""The corrector in the servo thread of such a LinuxCNC."""
