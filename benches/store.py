"""The store beside what a user would pick instead: sqlite3 by hand, a JSON document a part, a folder of CSV files.

Keeping many touches of one part, finding one part's life among many parts, and how long a million touches and a hundred
thousand parts take: `python -m benches.store [PARTS [TOUCHES]]`, or `large`.
"""

import csv
import json
import sqlite3
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from typing import Final

from benches.ratio import Contender, compare
from trueloop.domain.inspection import Inspection, Touch
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Edge, Setting, Tool
from trueloop.domain.values import CODEC
from trueloop.storage.integrity import damage
from trueloop.storage.store import Store, find, keep, life, open_store

AT: Final = datetime(2026, 1, 2, tzinfo=UTC)
TYPE: Final = PartType("shaft", "B", "C45")
SETTING: Final = Setting(Edge(Tool(3, "SVJBR 2020", 0.8), "VBMT 1604", "A"), AT)
NUMBERS: Final = count()
COLUMNS: Final = ("point", "x_mm", "z_mm", "error_mm")


def main(parts: int = 2_000, touches: int = 20_000) -> None:
    """Compare, then time the large ones alone."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        given = touched("1", touches)
        compare(
            f"keep {touches} touches of a part, on disk", keepers(folder, given), rounds=5, note_heading="reads back"
        )
        compare(f"all of one part among {parts}", finders(folder, parts), rounds=5)


def touched(serial: str, touches: int, sha256: str = "") -> Inspection:
    """Touches whose errors are no short decimals."""
    values = tuple(Touch(str(k), (10.0 + k / 3, -k / 7), "dome", error_mm=k / 7e6, line=k + 2) for k in range(touches))
    return Inspection(Part(TYPE, serial), "touches", sha256 or f"{int(serial):064x}", touches, values, measured_at=AT)


def rows(inspection: Inspection) -> list[tuple[str, float, float, float | None]]:
    """What a user would write down of touches."""
    return [(one.point, *one.nominal_mm, one.error_mm) for one in inspection.touches]


def keepers(folder: Path, given: Inspection) -> list[Contender]:
    """Each keeps the touches as those of another part at every call, so that all is on the disk when it returns."""
    store = open_store(folder / "trueloop.db", create=True)
    by_hand = sqlite3.connect(folder / "by-hand.db", isolation_level=None)
    by_hand.execute("PRAGMA journal_mode = WAL")
    by_hand.execute("PRAGMA synchronous = FULL")
    by_hand.execute("CREATE TABLE touch (part TEXT, point TEXT, x REAL, z REAL, error REAL)")

    def ours() -> None:
        number = next(NUMBERS)
        keep(store, [Inspection(Part(TYPE, str(number)), "touches", f"{number:064x}", given.count, given.values)])

    def sqlite() -> None:
        number = str(next(NUMBERS))
        by_hand.execute("BEGIN")
        by_hand.executemany("INSERT INTO touch VALUES (?, ?, ?, ?, ?)", ((number, *row) for row in rows(given)))
        by_hand.execute("COMMIT")

    def document() -> None:
        (folder / f"{next(NUMBERS)}.json").write_text(CODEC.to_json(given), encoding="utf-8")

    def table() -> None:
        with (folder / f"{next(NUMBERS)}.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([COLUMNS, *rows(given)])

    return [
        Contender("trueloop", ours, "bit for bit, hashed, once"),
        Contender("sqlite3 by hand", sqlite, "4 of 8 fields, no hash, twice if asked twice"),
        Contender("a JSON document", document, "bit for bit, not synced, no index"),
        Contender("a CSV file", table, "4 of 8 fields, not synced, no index"),
    ]


def finders(folder: Path, parts: int) -> list[Contender]:
    """One part of many: ours by its index; files have to be read until it is found, unless their names say it."""
    store = filled(folder / "many.db", parts)
    documents, tables = folder / "documents", folder / "tables"
    for made in (documents, tables):
        made.mkdir()
    for k in range(parts):
        given = touched(str(k), 20)
        (documents / f"{k}.json").write_text(CODEC.to_json(given), encoding="utf-8")
        with (tables / f"{k}.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([COLUMNS, *rows(given)])
    wanted = Part(TYPE, str(parts // 2))

    def by_content() -> object:
        files = (json.loads(file.read_text(encoding="utf-8")) for file in documents.iterdir())
        return [one for one in files if one["part"]["serial"] == wanted.serial]

    def by_name() -> object:
        with (tables / f"{wanted.serial}.csv").open(encoding="utf-8") as file:
            return list(csv.DictReader(file))

    return [
        Contender("trueloop: cuts, inspection, links", lambda: life(store, wanted)),
        Contender("JSON documents, by content", by_content),
        Contender("CSV file whose name is known, touches alone", by_name),
    ]


def filled(file: Path, parts: int) -> Store:
    """A store of parts, each with a semi-finish and a finish cut, an inspection of twenty touches, and their link."""
    store = open_store(file, create=True)
    for start in range(0, parts, 1000):
        values: list[object] = []
        for k in range(start, min(parts, start + 1000)):
            one = touched(str(k), 20)
            cuts = [Cut(one.part, stage, SETTING, at=AT) for stage in (Stage.SEMIFINISH, Stage.FINISH)]
            values += [one, *cuts, InspectionLink(one.identity, cuts[0].identity)]
        keep(store, values)
    return store


def large(parts: int = 100_000, touches: int = 1_000_000) -> None:
    """A million touches kept, checked and read; a part's life among a hundred thousand: seconds, for the docs."""
    with tempfile.TemporaryDirectory() as name:
        store, given = open_store(Path(name) / "touches.db", create=True), touched("1", touches)
        timed(f"keep {touches} touches", lambda: keep(store, [given]))
        timed("check all of it", lambda: damage(store))
        timed("read them back", lambda: find(store, Inspection))
        many = filled(Path(name) / "many.db", parts)
        life(many, Part(TYPE, "0"))
        timed(
            f"100 lives of {parts} parts", lambda: [life(many, Part(TYPE, str(k * parts // 100))) for k in range(100)]
        )


def timed(what: str, run: Callable[[], object]) -> None:
    """Once."""
    start, cpu = time.perf_counter(), time.process_time()
    run()
    print(
        f"{what}: {time.perf_counter() - start:.2f} s, of which computing {time.process_time() - cpu:.2f} s", flush=True
    )


if __name__ == "__main__":
    if sys.argv[1:] == ["large"]:
        large()
    else:
        main(*map(int, sys.argv[1:]))
