"""A virtual machine with known errors, its probe and its measuring machine: the truth that a loop is tried against."""
