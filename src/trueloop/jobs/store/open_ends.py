"""Corrections that were kept and of which nobody said what the finish cut left."""

from collections.abc import Iterator, Sequence

from trueloop.domain.life import InspectionLink, Stage
from trueloop.domain.part import Part
from trueloop.domain.record import Correction
from trueloop.domain.tool import Edge
from trueloop.errors import Code, Finding, Severity
from trueloop.jobs.store.of_this_part import cuts_of
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find


def parts_without_inspection(store: Store, edge: Edge) -> tuple[Part, ...]:
    """Parts with a correction for this edge and no inspection of their finish cut, in the order of corrections."""
    found = find(store, Correction, edge=joined(edge.identity))
    parts = {one.part.identity: one.part for kept in found for one in kept.value.record.inspections}
    return tuple(part for part in parts.values() if not _inspected(store, part))


def without_inspection(store: Store, edge: Edge, but: Part) -> Iterator[Finding]:
    """Yields a note of the parts of an edge whose finish cut was not inspected, besides the one at hand."""
    parts = [part for part in parts_without_inspection(store, edge) if part.identity != but.identity]
    if parts:
        serials = [part.serial for part in parts]
        yield Finding(
            Severity.NOTE,
            Code.STO_OPEN,
            f"{len(parts)} parts of this edge have a correction and no finish inspection: {_listed(serials)}; they "
            "teach nothing of the finish cut",
            hint="hand it in: `trueloop measure read FILE --job JOB.toml --after finish`, with --ran as-programmed "
            "where the correction was not run",
            values={"serials": serials[:SHOWN]},
        )


SHOWN = 6


def _listed(serials: Sequence[str]) -> str:
    return ", ".join(map(repr, serials[:SHOWN])) + (", …" if len(serials) > SHOWN else "")


def _inspected(store: Store, part: Part) -> bool:
    return any(find(store, InspectionLink, cut=joined(cut.identity)) for cut in cuts_of(store, part, Stage.FINISH))
