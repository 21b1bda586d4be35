"""Stores to test: a new one in SQLite or in PostgreSQL."""

from tests.unit.storage.conftest import place, server, store, stored_at

__all__ = ["place", "server", "store", "stored_at"]
