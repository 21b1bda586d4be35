"""The corrector in the servo thread of LinuxCNC: its component, its lines of HAL, its signals, its watcher."""
