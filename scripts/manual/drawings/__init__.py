"""The drawings of the manual, made by code: `python -m scripts.manual.drawings` writes them into docs/images."""
