"""What a shop does: orders, proposals, decisions, runs, certificates. Pure decisions, and one shell that does them."""
