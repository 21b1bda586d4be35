"""Inspection files: what gauges, measuring machines and controls report, read into inspections."""
