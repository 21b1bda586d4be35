"""The stability of a series: control charts with their rules, and capability with its intervals."""
