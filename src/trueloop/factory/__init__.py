"""The operations of a shop: orders, proposals, decisions, runs, certificates. Pure decisions, and one shell that does
them.
"""
