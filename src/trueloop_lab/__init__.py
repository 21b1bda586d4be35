"""Virtual machines, on which the loops are tried, shown and studied: `trueloop simulate` and the demonstrations."""
