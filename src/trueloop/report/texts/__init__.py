"""Texts of pages, in the reader's language and unit."""
