"""The memory of one cutting edge: the state of its errors (`estimate`), from part to part."""
