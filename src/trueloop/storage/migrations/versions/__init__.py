"""The schemas in order. A script states its tables itself: what the program knows today may be otherwise."""
