"""A displaced contour into an NC program or a tool offset, and the written program read back."""
