"""Parts inspected on the machine and on a measuring machine, versions of machine models, standard parts."""

from typing import Final

from trueloop.storage.migrations.versions.v0001_first import guard, make_kind

revision: Final = "0002"
down_revision: Final = "0001"

KINDS: Final = {
    "both_inspections": ("part_type", "serial", "machine"),
    "model_version": ("machine", "parent_sha256"),
    "model_decision": ("verdict",),
    "standard_part": ("part_type", "serial"),
}


def upgrade() -> None:
    """Makes the tables and what guards them."""
    for table, columns in KINDS.items():
        make_kind(table, columns)
    guard(tuple(KINDS))
