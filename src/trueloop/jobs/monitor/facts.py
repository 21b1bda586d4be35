"""What the store holds of each part of a series beside its sizes."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from statistics import fmean

from trueloop.domain.both_inspections import BothInspections
from trueloop.domain.edge_life import time_of
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, EdgeEvent, EdgeEventKind, Stage
from trueloop.factory.book import Book
from trueloop.loops.monitor.facts import PartFacts
from trueloop.loops.post_process.series import Made
from trueloop.storage.store import Store, find

ANEW = (EdgeEventKind.MOUNTED, EdgeEventKind.TURNED, EdgeEventKind.SET)
"""Events after which a tip lies elsewhere."""


@dataclass(frozen=True)
class StoredFacts:
    """All that the store holds of the parts of one type, by what it is found by."""

    book: Book
    cuts: Mapping[str, Cut]
    events: tuple[EdgeEvent, ...]
    stood: Mapping[str, Mapping[str, float]]
    failed: Mapping[str, tuple[tuple[datetime, str], ...]]

    def of(self, made: Sequence[Made]) -> tuple[PartFacts, ...]:
        """Facts of the parts of one series, in its order."""
        minutes = _minutes([self.cuts.get(one.serial) for one in made])
        return tuple(self._part(made, k, minutes[k]) for k in range(len(made)))

    def _part(self, made: Sequence[Made], k: int, minutes: float | None) -> PartFacts:
        inspection = self._inspection(made[k])
        cut, before = self.cuts.get(made[k].serial), self.cuts.get(made[k - 1].serial) if k else None
        at = inspection.measured_at if cut is None or time_of(cut) is None else time_of(cut)
        earlier = None if not k else self._at(made[k - 1])
        return PartFacts(
            made[k].serial,
            at,
            cut,
            tuple(self._events(before, cut)),
            tuple(self._accepted(earlier, at)) if k and made[k].correction_mm != made[k - 1].correction_mm else (),
            minutes,
            _temperatures(inspection) | dict(self.stood.get(made[k].serial, {})),
            inspection.device,
            self._failed(inspection),
        )

    def _inspection(self, made: Made) -> Inspection:
        return next(one.inspection for one in self.book.parts if one.inspection.identity == made.inspection)

    def _at(self, made: Made) -> datetime | None:
        cut = self.cuts.get(made.serial)
        return self._inspection(made).measured_at if cut is None else time_of(cut)

    def _events(self, before: Cut | None, cut: Cut | None) -> Iterator[EdgeEvent]:
        """Of the tool that cuts, between two cuts whose times are known."""
        if before is None or cut is None or cut.setting is None or before.at is None or cut.at is None:
            return
        tool = cut.setting.edge.tool.identity
        for one in self.events:
            if one.edge.tool.identity == tool and one.kind in ANEW and _utc(before.at) < _utc(one.at) <= _utc(cut.at):
                yield one

    def _accepted(self, earlier: datetime | None, at: datetime | None) -> Iterator[str]:
        for one in self.book.decisions:
            late = at is not None and _utc(one.at) > _utc(at)
            early = earlier is not None and _utc(one.at) <= _utc(earlier)
            if one.verdict == "accepted" and not late and not early:
                yield one.proposal

    def _failed(self, inspection: Inspection) -> str:
        """What the last check of the device before the inspection said, where it failed."""
        checks = self.failed.get(inspection.device, ())
        if inspection.measured_at is None:
            return ""
        past = [said for at, said in checks if _utc(at) <= _utc(inspection.measured_at)]
        return past[-1] if past else ""


def stored_facts(
    store: Store, book: Book, failed: Mapping[str, tuple[tuple[datetime, str], ...]] | None = None
) -> StoredFacts:
    """What the store holds of the parts of a book; `failed`: what checks of devices said, "" where they passed."""
    cuts = [one.value for one in find(store, Cut, part_type=book.part_type, stage=Stage.FINISH)]
    both = [one.value for one in find(store, BothInspections, part_type=book.part_type)]
    return StoredFacts(
        book,
        {one.part.serial: one for one in cuts},
        tuple(one.value for one in find(store, EdgeEvent)) if cuts else (),
        {one.part.serial: {f"{name} while cut": v for name, v in one.cutting.signals.items()} for one in both},
        failed or {},
    )


def _minutes(cuts: Sequence[Cut | None]) -> list[float | None]:
    """What the edge of each cut had cut before it, as far back as every cut of it says its time."""
    age: dict[tuple[str, ...], float | None] = {}
    found: list[float | None] = []
    for cut in cuts:
        edge = None if cut is None or cut.setting is None else cut.setting.edge.identity
        if cut is None or edge is None:
            found.append(None)
            continue
        now, minutes = age.get(edge, 0.0), cut.conditions.time_in_cut_min
        found.append(now)
        age[edge] = None if now is None or minutes is None else now + minutes
    return found


def _temperatures(inspection: Inspection) -> dict[str, float]:
    read = [one.temperature_c for one in inspection.readings if one.temperature_c is not None]
    of_readings = {"part while measured": fmean(read)} if read else {}
    return {f"{name} while measured": value for name, value in inspection.temperatures.items()} | of_readings


def _utc(at: datetime) -> datetime:
    return at if at.tzinfo else at.replace(tzinfo=UTC)
