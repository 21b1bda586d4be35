"""A replay written: its table and its page."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from studies.replay.page import replay_page
from studies.replay.replay import Replayed
from studies.replay.table import replay_csv
from trueloop.formats.input_file import FilePath
from trueloop.formats.outputs import write_all


def write_replay(
    folder: FilePath,
    name: str,
    source: str,
    fits: Sequence[Replayed],
    memory: Mapping[str, Sequence[Replayed]],
    as_first: Sequence[Replayed] = (),
) -> list[Path]:
    """`replay.csv`, `replay.html` and, where there is one, `as-first.csv`; their paths.

    `fits` are all parts by the fit of their own touches, `memory` the replays by how they are called: "20 touches".
    A part of which a later replay used as many touches as an earlier one is in the table once, from the earlier one.
    """
    rows = {(one.part.serial, one.touches): one for replayed in reversed(list(memory.values())) for one in replayed}
    order = [one for replayed in memory.values() for one in replayed if rows[one.part.serial, one.touches] is one]
    files = [
        ("replay.csv", replay_csv(order).encode()),
        ("replay.html", replay_page(name, source, fits, memory, as_first).encode()),
    ]
    if as_first:
        files.append(("as-first.csv", replay_csv(as_first).encode()))
    return write_all(folder, files)
