"""What was read of an agent: as a table, as JSON, as CSV."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from trueloop.cli.terminal import print_json, print_table
from trueloop.controllers.mtconnect.agent import Seen, temperature_log
from trueloop.formats.outputs import write_all

COLUMNS: Final = ("item", "name", "type", "units", "time", "sequence", "value")


def keep(url: str, found: Sequence[Seen], out: Path | None, log: Path | None) -> list[Path]:
    """Writes what is asked for; no file that is there is overwritten."""
    files = [(out, _csv(found))] if out else []
    files += [(log, temperature_log(url, found))] if log else []
    written: list[Path] = []
    for path, text in files:
        written += write_all(path.parent, [(path.name, text.encode())], [path] if path.exists() else [])
    return written


def show(found: Sequence[Seen], *, as_json: bool) -> None:
    """Prints a machine's state on stdout."""
    rows = [_row(one) for one in found]
    if as_json:
        print_json({"observations": [dict(zip(COLUMNS, row, strict=True)) for row in rows]})
    else:
        print_table(COLUMNS, [[str(cell) for cell in row] for row in rows])


def _csv(found: Sequence[Seen]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows(_row(one) for one in found)
    return text.getvalue()


def _row(one: Seen) -> tuple[str | int, ...]:
    return one.item.id, one.item.name, one.item.type, one.item.units, one.stamp, one.sequence, one.value
