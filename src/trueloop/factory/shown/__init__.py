"""The service's answers, filled from the store: few queries each, lists by cursor, nothing written."""
