"""Tables for controls and stored models."""
