"""Whether a series stays what it was: control charts with their rules, and capability with its intervals."""
