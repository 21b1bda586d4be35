"""Attempts to sign in that failed are counted by the running service, by a clock that is never set: no table."""

from typing import Final

from alembic import op

revision: Final = "0006"
down_revision: Final = "0005"


def upgrade() -> None:
    """Removes the table, which nothing has written."""
    op.drop_table("attempt")
