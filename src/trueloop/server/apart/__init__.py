"""Files that people hand over are read in processes apart, which may die of them."""
