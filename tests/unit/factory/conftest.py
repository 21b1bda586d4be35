"""Stores to test: a new one in SQLite or in PostgreSQL."""

from tests.unit.storage.conftest import place, store, stored_at

__all__ = ["place", "store", "stored_at"]
