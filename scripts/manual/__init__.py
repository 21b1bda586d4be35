"""The manual as a static site, made from docs/: `python -m scripts.manual` (or `make docs`)."""
