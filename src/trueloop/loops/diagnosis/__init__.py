"""Diagnoses put together: values in, values out."""
