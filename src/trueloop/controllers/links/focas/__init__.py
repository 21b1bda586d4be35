"""Fanuc controls, by the FOCAS library that the user has of Fanuc."""
