"""What a store says of a series: in which order, cut with what, learned from or not."""

from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from typing import get_args

import pytest

from tests.support.series import MADE, inspection
from trueloop.cli.series import AGE_H, LARGEST_UM, LEAST_UM, Class, Override
from trueloop.domain.life import Cut, InspectionLink, Quarantine, Stage
from trueloop.domain.part import Part, PartType
from trueloop.domain.proposal import PartCutWith, Proposal, ProposalDecision
from trueloop.domain.tool import Edge, Setting, Tool
from trueloop.errors import Code, TrueloopError
from trueloop.factory.book import Book, only_type, read_book
from trueloop.jobs.series import Adding, add_inspections, status_of
from trueloop.loops.post_process.decide import OVERRIDES
from trueloop.loops.post_process.propose import ProposalContext, proposals_of
from trueloop.loops.post_process.series import NAMES, SeriesOptions
from trueloop.storage.store import Store, keep, open_store
from trueloop.units import UM_PER_MM

OPTIONS = SeriesOptions()
TYPE = PartType("SHAFT")


def _store(*errors_um: float) -> Store:
    store = open_store("sqlite://", create=True)
    keep(store, [inspection(str(k), {"journal": error}, hours=k) for k, error in enumerate(errors_um, 1)])
    return store


def _cut(serial: str, **given: object) -> Cut:
    return Cut(Part(TYPE, serial), Stage.FINISH, **given)  # type: ignore[arg-type]


def _accepted(store: Store) -> Proposal:
    (proposal,) = proposals_of(read_book(store, "SHAFT", OPTIONS).tracked, OPTIONS, ProposalContext("me", MADE))
    keep(store, [proposal, ProposalDecision(proposal.id, "accepted", "me", MADE + timedelta(hours=3.5))])
    return proposal


def _corrections_um(book: Book) -> list[float]:
    return [round(1000 * one.made.correction_mm, 3) for one in book.tracked[0].parts]


def test_parts_measured_after_a_decision_were_cut_with_it_unless_it_is_said_otherwise() -> None:
    store = _store(26.0, 29.0, 28.0)
    change_um = 1000 * _accepted(store).effects[0].size_change_mm
    fourth, fifth = (inspection(str(k), {"journal": 8.0}, hours=k) for k in (4, 5))
    keep(store, [fourth, fifth, PartCutWith(fifth.identity, ())])
    book = read_book(store, "SHAFT", OPTIONS)
    assert _corrections_um(book) == pytest.approx([0, 0, 0, -change_um, 0], abs=1e-3)
    shown = status_of(book, OPTIONS).characteristics[0].parts[3]
    assert (shown.correction_um, shown.after_um) == pytest.approx((-change_um, 8.0), abs=1e-3)
    assert book.tracked[0].in_force_mm == pytest.approx(-change_um / 1000)


def test_the_next_proposal_counts_from_what_is_in_force() -> None:
    store = _store(26.0, 29.0, 28.0)
    first = _accepted(store)
    assert proposals_of(read_book(store, "SHAFT", OPTIONS).tracked, OPTIONS, ProposalContext("me", MADE)) == ()
    keep(store, [inspection(str(k), {"journal": 9.0}, hours=k) for k in (4, 5, 6)])
    (second,) = proposals_of(read_book(store, "SHAFT", OPTIONS).tracked, OPTIONS, ProposalContext("me", MADE))
    assert -9.5 < 1000 * second.effects[0].size_change_mm < -6.0, "what is left, not all of it again"
    assert second.effects[0].in_force_mm == pytest.approx(-first.effects[0].size_change_mm)


def test_cuts_say_the_order_when_the_tool_was_set_and_what_teaches_nothing() -> None:
    store = _store(1.0, 2.0, 3.0)
    edge = Edge(Tool(3), "DNMG", "a")
    early, late = Setting(edge, MADE), Setting(edge, MADE + timedelta(hours=1))
    cuts = [_cut("1", order=3, setting=late), _cut("2", order=1, setting=early), _cut("3", order=2, setting=early)]
    keep(store, [*cuts, Quarantine(cuts[2].identity, MADE, "chatter")])
    (one,) = read_book(store, "SHAFT", OPTIONS).tracked
    assert [(m.made.serial, m.made.set_before, m.made.counts) for m in one.parts] == [
        ("2", False, True),
        ("3", False, False),
        ("1", True, True),
    ]


def test_inspections_before_the_finish_cut_are_no_parts_of_a_series() -> None:
    store = _store(1.0, 2.0)
    rough = inspection("9", {"journal": 250.0}, hours=9)
    cut = replace(_cut("9"), stage=Stage.SEMIFINISH)
    keep(store, [rough, cut, InspectionLink(rough.identity, cut.identity)])
    assert [one.serial for one in read_book(store, "SHAFT", OPTIONS).parts] == ["1", "2"]


def test_of_a_part_inspected_twice_the_later_inspection_counts() -> None:
    store = _store(1.0, 2.0)
    keep(store, [inspection("2", {"journal": 5.0}, hours=2, sha256="again")])
    book = read_book(store, "SHAFT", OPTIONS)
    assert [1000 * one.made.error_mm for one in book.tracked[0].parts] == pytest.approx([1.0, 5.0])
    assert Code.SER_AGAIN in [one.code for one in book.findings]


def test_a_store_of_no_or_several_part_types_asks_which() -> None:
    store = open_store("sqlite://", create=True)
    with pytest.raises(TrueloopError, match="SER-UNKNOWN"):
        only_type(store)
    keep(store, [inspection("1", {"journal": 1.0})])
    assert only_type(store) == "SHAFT"
    with pytest.raises(TrueloopError, match="SER-UNKNOWN"):
        read_book(store, "shaft 2", OPTIONS)


def test_of_a_file_of_several_part_types_the_stated_one_is_added(tmp_path: Path) -> None:
    """A shaft and a bush with one serial number are two parts."""
    file = tmp_path / "mixed.csv"
    rows = "shaft;1;Ø 1;25;25.01\nbush;1;Ø 1;40;40.02\nshaft;2;Ø 1;25;25.02\n"
    file.write_text("Part;Serial;Characteristic;Nominal [mm];Actual\n" + rows)
    store = open_store("sqlite://", create=True)
    for stated in ("", "SH"):
        with pytest.raises(TrueloopError) as refused:
            add_inspections(store, [file], Adding(stated))
        assert refused.value.code is Code.SER_PART and "--type shaft" in (refused.value.hint or "")
    assert [add_inspections(store, [file], Adding(name))[0].new for name in ("bush", "shaft")] == [("1",), ("1", "2")]


def test_the_commands_name_what_the_code_has() -> None:
    assert (OPTIONS.largest_mm * UM_PER_MM, OPTIONS.least_mm * UM_PER_MM) == (LARGEST_UM, LEAST_UM)
    assert OPTIONS.age_hours == AGE_H
    assert {one.value for one in Class} == set(NAMES)
    assert {one.value for one in Override} == set(OVERRIDES.values())
    assert get_args(ProposalDecision.__annotations__["verdict"]) == ("accepted", "rejected")
