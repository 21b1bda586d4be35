"""A pattern to a displaced surface and to a displaced milling program."""
