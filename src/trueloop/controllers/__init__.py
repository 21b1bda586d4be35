"""Code for single controls: probing programs and their logs, and LinuxCNC run for real."""
