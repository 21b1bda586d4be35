"""The store: domain values kept in SQLite, or in PostgreSQL for a plant. Append-only; what was kept never changes."""
