"""A machine's sensors and what each showed last are found without reading every temperature that it ever had."""

from typing import Final

from alembic import op

revision: Final = "0005"
down_revision: Final = "0004"


def upgrade() -> None:
    """Replaces the index."""
    op.create_index("temperature_by_machine_signal_at", "temperature", ["machine", "signal", "at"])
    op.drop_index("temperature_by_machine_at", "temperature")
