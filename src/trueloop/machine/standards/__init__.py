"""Calibrated plates and positioning tests."""
