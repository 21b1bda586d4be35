"""What rows of a store say of each other: links that lead somewhere, labels and times that agree."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import PurePath
from typing import Any

from trueloop.domain.correction import Correction
from trueloop.domain.inspection import Inspection
from trueloop.domain.labelled import contradictions
from trueloop.domain.labels import labels_in
from trueloop.domain.life import Cut, Identity, InspectionLink, Stage
from trueloop.domain.program import Program
from trueloop.domain.record import Record
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.jobs.db.found import row_name
from trueloop.jobs.store.of_this_part import require_later
from trueloop.jobs.store.order import Dated, cutting_order
from trueloop.storage.kept import Kept


@dataclass
class Facts:
    """What is compared, of rows that are not superseded; inspections without their values, which may be many."""

    inspections: dict[Identity, Inspection] = field(default_factory=dict)
    cuts: dict[Identity, Kept[Cut]] = field(default_factory=dict)
    links: list[Kept[InspectionLink]] = field(default_factory=list)
    records: dict[str, tuple[str, Record]] = field(default_factory=dict)
    programs: dict[str, str] = field(default_factory=dict)

    def take(self, kept: Kept[Any]) -> None:
        """Adds a row."""
        value = kept.value
        if isinstance(value, Inspection):
            self.inspections[value.identity] = replace(value, values=())
        elif isinstance(value, Cut):
            self.cuts[value.identity] = kept
        elif isinstance(value, InspectionLink):
            self.links.append(kept)
        elif isinstance(value, Program):
            self.programs[value.sha256] = value.name
        elif isinstance(value, Correction):
            small = replace(value.record, inspections=(), model={}, changes=[])
            self.records[value.record.id] = row_name(Correction, kept.row), small


def odd_links(facts: Facts) -> Iterator[Finding]:
    """STO-LOST: links and cuts that name what is not in the store, or what is superseded."""
    for link in facts.links:
        row = row_name(InspectionLink, link.row)
        if link.value.inspection not in facts.inspections:
            yield _no_such(row, "inspection", link.value.inspection)
        if link.value.cut not in facts.cuts:
            yield _no_such(row, "cut", link.value.cut)
    for cut in facts.cuts.values():
        if cut.value.correction and cut.value.correction not in facts.records:
            yield _no_such(row_name(Cut, cut.row), "correction", (cut.value.correction,))


def odd_labels(facts: Facts) -> Iterator[Finding]:
    """LAB-LINK: labels in the names of programs, and of the files of a record, against cuts and inspections."""
    for cut in facts.cuts.values():
        name, part = facts.programs.get(cut.value.program_sha256, ""), cut.value.part
        for label in labels_in(PurePath(name).name):
            place = Place(row_name(Cut, cut.row))
            yield from contradictions(label, part.part_type, part.serial, cut.value.stage, place)
    by_file: dict[str, list[Inspection]] = {}
    for inspection in facts.inspections.values():
        by_file.setdefault(inspection.sha256, []).append(inspection)
    for row, record in facts.records.values():
        for name, sha256 in record.inputs_sha256.items():
            of_file = by_file.get(sha256, []) if labels_in(PurePath(name).name) else []
            yield from _labels_of_file(name, of_file, Place(row))


def odd_order(facts: Facts) -> Iterator[Finding]:
    """STO-ORDER: finish cuts of an edge whose order the facts contradict: an inspection before the cut before."""
    shown = {link.value.cut: facts.inspections.get(link.value.inspection) for link in facts.links}
    edges: dict[Identity, list[Kept[Cut]]] = {}
    for cut in facts.cuts.values():
        if cut.value.setting is not None and cut.value.stage is Stage.FINISH:
            edges.setdefault(cut.value.setting.edge.identity, []).append(cut)
    for edge, cuts in edges.items():
        inspected = [shown.get(one.value.identity) for one in cuts]
        at = [None if one is None else one.measured_at for one in inspected]
        order = cutting_order([Dated(one.value, when, one.row) for one, when in zip(cuts, at, strict=True)])
        doubted = [cuts[k] for k, doubt in zip(order.places, order.in_doubt, strict=True) if doubt]
        if doubted:
            yield _in_doubt(edge, doubted)


def odd_times(facts: Facts) -> Iterator[Finding]:
    """STO-CLOCK: an inspection before the cut that it shows."""
    for link in facts.links:
        cut, inspection = facts.cuts.get(link.value.cut), facts.inspections.get(link.value.inspection)
        if cut is not None and inspection is not None:
            try:
                what = row_name(InspectionLink, link.row)
                require_later(
                    (f"{row_name(Cut, cut.row)}, which it shows,", cut.value.at),
                    (f"the inspection of {what}", inspection.measured_at),
                )
            except TrueloopError as wrong:
                yield Finding(Severity.WARNING, wrong.code, wrong.message, wrong.hint, wrong.place, wrong.values)


def _labels_of_file(name: str, of_file: list[Inspection], place: Place) -> Iterator[Finding]:
    """Of a file with several inspections one has to agree: a label names one part."""
    for label in labels_in(PurePath(name).name):
        found = [contradictions(label, one.part.part_type, one.part.serial, place=place) for one in of_file]
        if found and all(found):
            yield from found[0]


def _in_doubt(edge: Identity, cuts: list[Kept[Cut]]) -> Finding:
    serials = [one.value.part.serial for one in cuts]
    return Finding(
        Severity.WARNING,
        Code.STO_ORDER,
        f"the order in which edge {'/'.join(edge)!r} cut its parts is in doubt for {', '.join(map(repr, serials[:10]))}"
        + ("" if len(serials) <= 10 else f" and {len(serials) - 10} more"),
        "state the order or the times of these cuts: trueloop db replace ROW FILE --why …",
        values={"serials": serials[:10]},
    )


def _no_such(row: str, what: str, identity: Identity) -> Finding:
    shown = "/".join(identity)
    return Finding(
        Severity.ERROR,
        Code.STO_LOST,
        f"{row} names the {what} {shown!r}, which is not in the store, or is superseded",
        f"import the {what}, or replace the row that is wrong: trueloop db replace ROW FILE --why …",
        values={"row": row, "named": shown},
    )
