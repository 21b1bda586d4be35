"""The unit of the lengths that an account is shown: those that were made before see what they saw, millimetres."""

from typing import Final

import sqlalchemy as sa
from alembic import op

revision: Final = "0004"
down_revision: Final = "0003"


def upgrade() -> None:
    """Adds the column."""
    op.add_column("account", sa.Column("unit", sa.Text, nullable=False, server_default="mm"))
