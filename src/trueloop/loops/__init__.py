"""Ways of running the flow: each strings the pieces together."""
