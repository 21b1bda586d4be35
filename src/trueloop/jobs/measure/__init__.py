"""Inspection files and measuring plans of a job."""
