"""Series of parts: values as JSON, lines for a terminal, the page."""
