"""LinuxCNC as a real controller: run headless, with a virtual part in the control's own hardware layer."""
