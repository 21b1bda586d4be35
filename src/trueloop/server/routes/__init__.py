"""The addresses, each a few lines: what is asked goes to `factory`, what it answers goes out as JSON."""
