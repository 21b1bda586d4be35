"""What memory made of parts: the page and the table of a replay."""
