"""Diagnoses: values as JSON, lines for a terminal, pages."""
