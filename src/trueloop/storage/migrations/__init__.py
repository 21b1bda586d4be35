"""Migrations of the store's tables: one script a schema, none of them ever changed."""
