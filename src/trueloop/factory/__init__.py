"""Operations of a shop: orders, proposals, decisions, runs, certificates; pure decisions, one shell that does them."""
