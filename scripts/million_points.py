"""How long a million points of a measuring machine take: read, matched with the part, judged, kept, and checked.

`python -m scripts.million_points [POINTS [FILES [URL]]]`: so many points in so many QIF files of one part type, into a
new SQLite store or the empty database at URL. Processor time beside wall time: the machine may have other work.
"""

import math
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Final, TypeVar

from scripts.large_qif import HEAD
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.errors import Severity
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.geometry.profile import Profile
from trueloop.jobs.measure.measured import read_measured, read_part_of_job
from trueloop.storage.integrity import damage
from trueloop.storage.store import keep, open_store

T = TypeVar("T")
JOB: Final = Path(__file__).parents[1] / "examples" / "loop" / "modbas2.toml"
TAIL: Final = """</Points><Compensated>true</Compensated></MeasuredPointSet></MeasuredPointSets>
<ActualComponentIds><Id>2</Id></ActualComponentIds></MeasurementResults></MeasurementResultsSet>
<ActualComponentSets><ActualComponentSet><ActualComponent id="2"><SerialNumber>{serial}</SerialNumber></ActualComponent>
</ActualComponentSet></ActualComponentSets></Results></QIFDocument>
"""
OFF_MM: Final = 0.003
"""Part errors go up and down by so much."""


def main(points: int = 1_000_000, files: int = 20, *, url: str = "") -> None:
    """Writes the files, then times."""
    with tempfile.TemporaryDirectory() as name:
        part = read_part_of_job(JOB)
        lines = _lines(part.profile, points // files)
        paths = [_written(Path(name), lines, points // files, k) for k in range(files)]
        store = open_store(url or str(Path(name) / "trueloop.db"), create=True)
        clock = _Clock()
        for path in paths:
            found = clock.took("read, matched, judged", partial(read_measured, path, StatedFacts(None), part))
            assert not [one for each in found.on_part for one in each.findings if one.severity is Severity.ERROR]
            (one,) = found.on_part
            assert one.matches is not None and len(one.matches.touches) == points // files, "each point is of the part"
            clock.took("kept", partial(keep, store, [*_facts(one.inspection)]))
        wrong = clock.took("checked: every hash of the store", lambda: list(damage(store)))
        assert not wrong, wrong
        clock.say(points, store.engine.dialect.name)
        store.close()


def _facts(inspection: Inspection) -> Iterator[object]:
    cut = Cut(inspection.part, Stage.FINISH)
    yield from (inspection.part, cut, inspection, InspectionLink(inspection.identity, cut.identity))


def _lines(profile: Profile, count: int) -> str:
    """Points round the part on all its features, off by up to OFF_MM along the normal."""
    lines = []
    for k in range(count):
        feature = profile.features[k % len(profile.features)]
        s = (0.1 + 0.8 * (k * 0.618034 % 1.0)) * feature.length_mm
        at, normal = feature.point_mm(s), feature.outward_normal(s)
        (x, z), turn = at + OFF_MM * math.sin(k) * normal, k * 2.399963
        lines.append(f"{x * math.cos(turn):.5f} {x * math.sin(turn):.5f} {z:.5f}\n")
    return "".join(lines)


def _written(folder: Path, lines: str, count: int, number: int) -> Path:
    """The file of one part."""
    file = folder / f"{number}.qif"
    opening = f'<MeasuredPointSets n="1"><MeasuredPointSet id="5" count="{count}"><Points>'
    results = f'<Results><MeasurementResultsSet n="1"><MeasurementResults id="4">{opening}'
    file.write_text(f"{HEAD}{results}{lines}{TAIL.format(serial=f'S{number}')}", encoding="utf-8")
    return file


class _Clock:
    """Seconds by what was done: wall and processor."""

    def __init__(self) -> None:
        self._spent: dict[str, tuple[float, float]] = {}

    def took(self, what: str, run: Callable[[], T]) -> T:
        """Does it."""
        wall, cpu = time.perf_counter(), time.process_time()
        done = run()
        before = self._spent.get(what, (0.0, 0.0))
        self._spent[what] = before[0] + time.perf_counter() - wall, before[1] + time.process_time() - cpu
        return done

    def say(self, points: int, store: str) -> None:
        """A line each, and the sum."""
        rows = [*self._spent.items(), ("in all", tuple(map(sum, zip(*self._spent.values(), strict=True))))]
        print(f"{points} points, {store}\n\n| | s | processor s |\n|---|--:|--:|")
        for what, (wall, cpu) in rows:
            print(f"| {what} | {wall:.1f} | {cpu:.1f} |")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]), url="".join(sys.argv[3:4]))
