"""The post-process loop: finished parts as inspected, what was expected of them, and proposals for the next part."""
