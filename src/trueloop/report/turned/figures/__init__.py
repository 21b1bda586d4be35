"""The figures of a turned part's page."""
