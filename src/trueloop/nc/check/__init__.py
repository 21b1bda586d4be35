"""Checks of a program before it cuts."""
