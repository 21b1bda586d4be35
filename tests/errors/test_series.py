"""Every way in which a series or a proposal is refused or flagged."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from datetime import timedelta
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from tests.loops.test_cut_with import FIRST, SECOND, correct
from tests.support.series import MADE, followed, inspection, reading, seen
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection
from trueloop.domain.part import PartType
from trueloop.domain.proposal import Proposal, ProposalDecision
from trueloop.errors import Code, Finding, TrueloopError
from trueloop.factory.book import Book, inspected_again
from trueloop.jobs.series import Adding, add_inspections, proposal_named, propose, tools_of_job
from trueloop.jobs.store import opened
from trueloop.loops.post_process.decide import OVERRIDES, decide, few_findings, usable
from trueloop.loops.post_process.propose import ProposalContext, proposals_of, tool_proposals
from trueloop.loops.post_process.series import PartSeen, SeriesOptions, When, parts_in_order, series_of
from trueloop.loops.post_process.tracked import TrackedSeries
from trueloop.storage.store import Store, find, open_store

MADE_BY = ProposalContext("me", MADE)
LEVEL = (26.0, 29.0, 28.0)
SHAFT_JOB = Path(__file__).parents[2] / "examples" / "shaft" / "job.toml"


def _store() -> Store:
    return open_store("sqlite://", create=True)


def _added(text: str) -> object:
    with TemporaryDirectory() as folder:
        file = Path(folder) / "parts.csv"
        file.write_text(text, encoding="utf-8")
        return add_inspections(_store(), [file], Adding())


def _findings(*inspections: Inspection) -> Sequence[Finding]:
    return usable([PartSeen(one) for one in inspections], take_nominal=False)[1]


def _revised() -> Inspection:
    return replace(inspection("2", {}), values=(reading("journal", 1.0, 24.1),))


def _filled_in() -> Inspection:
    return inspection("1", {"journal": 0.0, "seat": 0.0, "collar": 0.0})


def _in_inches() -> Inspection:
    return replace(inspection("2", {}), values=(reading("journal", 1.0, 24.0 * 25.4),))


def _decide(
    tracked: TrackedSeries,
    of: TrackedSeries | None = None,
    options: SeriesOptions | None = None,
    days: float = 0.0,
    earlier: Sequence[ProposalDecision] = (),
) -> object:
    proposal: Proposal = proposals_of([of or tracked], SeriesOptions(), MADE_BY)[0]
    now, series = MADE + timedelta(days=days), {tracked.series.identity: tracked}
    decisions = [replace(one, proposal=proposal.id) for one in earlier]
    return decide(proposal, "accepted", "me", now, series, decisions, options or SeriesOptions())


def _elsewhere() -> object:
    book = Book("SHAFT", (), (followed(*LEVEL, name="elsewhere"),), (), (), ())
    named = replace(book.tracked[0].series.characteristic, feature="nowhere")
    book = replace(
        book, tracked=(replace(book.tracked[0], series=replace(book.tracked[0].series, characteristic=named)),)
    )
    return tool_proposals(book.tracked, tools_of_job(SHAFT_JOB, book), SeriesOptions(), MADE_BY)


def _corrected() -> object:
    """Proposes for the second of two finished parts, which the correction of the first one cut."""
    with TemporaryDirectory() as folder:
        db = str(Path(folder) / "m.db")
        open_store(f"sqlite:///{db}", create=True)
        for part, readings in enumerate((FIRST, SECOND), 1):
            cut_with = f'cut_with = "o{part - 1}/record.json"' if part > 1 else ""
            correct(Path(folder), part, readings, "contour", cut_with, db=db)
        store = opened.open_store(db)
        sizes = [PartSeen(one.value) for one in find(store, Inspection)]
        return propose(store, Book("s", tuple(sizes), (), (), (), ()), SeriesOptions())


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.SER_PART: lambda: _added(
        "part name,characteristic,quantity,unit,nominal,actual\nSHAFT,journal,diameter,mm,24,24.01\n"
    ),
    Code.SER_NONE: lambda: _added(
        "part name,serial,characteristic,quantity,unit,actual\nSHAFT,7,journal,diameter,mm,24.01\n"
    ),
    Code.SER_NOMINAL: lambda: _findings(_filled_in()),
    Code.SER_UNIT: lambda: _findings(inspection("1", {"journal": 1.0}), _in_inches()),
    Code.SER_AGAIN: lambda: inspected_again(inspection("3", {"journal": 1.0}), 2),
    Code.SER_ORDER: lambda: parts_in_order([When("3811", 0, measured_at=MADE), When("3511", 1, measured_at=MADE)])[1],
    Code.SER_REVISION: lambda: _findings(inspection("1", {"journal": 1.0}), _revised()),
    Code.SER_UNKNOWN: lambda: _findings(inspection("1", {"journal": 1.0}), inspection("2", {"journl": 1.0})),
    Code.SER_FEW: lambda: list(few_findings(series_of(seen(26.0, 29.0)))),
    Code.SER_TOOL: _elsewhere,
    Code.SER_CORRECTED: _corrected,
    Code.SER_PROPOSAL: lambda: proposal_named(_store(), "ab12"),
    Code.SER_DECIDED: lambda: _decide(followed(*LEVEL), earlier=[ProposalDecision("", "accepted", "K. Roth", MADE)]),
    Code.SER_SUPERSEDED: lambda: _decide(followed(*LEVEL, 27.0), of=followed(*LEVEL)),
    Code.SER_LARGE: lambda: _decide(followed(*LEVEL), options=SeriesOptions(largest_mm=0.010)),
    Code.SER_OLD: lambda: _decide(followed(*LEVEL), days=8.0),
    Code.SER_ALARM: lambda: _decide(followed(*LEVEL, 27.0, 28.0, 90.0)),
}


@pytest.mark.parametrize("code", OVERRIDES)
def test_what_may_be_overridden_names_how(code: Code) -> None:
    with pytest.raises(TrueloopError) as refused:
        PRODUCERS[code]()
    assert f"--override {OVERRIDES[code]}" in (refused.value.override or "")


def test_part_type_and_form_are_kept_out_of_series() -> None:
    """Form has no sign that an offset could take out."""
    form = replace(reading("roundness", 3.0), quantity=Quantity.FORM)
    part = replace(inspection("1", {"journal": 1.0}), values=(form, reading("journal", 1.0)))
    (series,) = series_of([PartSeen(part)])
    assert series.name == "journal" and series.part_type == PartType("SHAFT")
