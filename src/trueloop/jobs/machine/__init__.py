"""Machine models from their files, and programs corrected by them."""
