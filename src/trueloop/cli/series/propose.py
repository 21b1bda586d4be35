"""`trueloop series propose`, `accept` and `reject`."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded
from trueloop.cli.numbers import positive
from trueloop.cli.offsets import Control
from trueloop.cli.series.options import AGE_H, LARGEST_UM, LEAST_UM, Which
from trueloop.cli.terminal import AsJson, busy, print_json, print_lines
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.domain.proposal import Proposal, ProposalDecision
    from trueloop.jobs.series.proposed import Written


class Class(StrEnum):
    """Classes of proposals, as `trueloop.loops.post_process.options.NAMES` has them; a test compares."""

    OFFSET = "offset"
    MEMORY = "memory"
    WEIGHT = "weight"


class Override(StrEnum):
    """Refusals that may be overridden, as `trueloop.loops.post_process.decide.OVERRIDES` has them; a test compares."""

    LARGE = "large"
    OLD = "old"
    SUPERSEDED = "superseded"
    ALARM = "alarm"


Id = Annotated[str, typer.Argument(metavar="ID", help="The proposal's id, or its beginning.")]
Who = Annotated[str | None, typer.Option("--who", help="Who decides.  [default: the user's name]")]
Why = Annotated[str, typer.Option("--why", help="For the record.")]


@guarded
def propose(
    which: Which,
    job: Annotated[
        Path | None,
        typer.Option("--job", "-j", help="The job whose tool cuts the part: the offsets of its tool, dX and dZ."),
    ] = None,
    min_um: Annotated[float, typer.Option("--min-um", min=0.0, help="Smaller changes are not proposed.")] = LEAST_UM,
    automatic: Annotated[
        list[Class] | None,
        typer.Option("--automatic", help="Accept proposals of this class at once; several times.  [default: none]"),
    ] = None,
    max_um: Annotated[
        float, typer.Option("--max-um", callback=positive, help="A larger change is not accepted at once.")
    ] = LARGEST_UM,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Propose what to change for the next part: offsets, memory begun anew after an alarm, weights."""
    from trueloop.jobs.series import proposed as series
    from trueloop.jobs.store.opened import opened
    from trueloop.loops.post_process.options import SeriesOptions, classes_named
    from trueloop.report.series.lines import proposal_as_dict, proposal_lines

    options = SeriesOptions(
        largest_mm=max_um / UM_PER_MM,
        least_mm=min_um / UM_PER_MM,
        take_nominal=which.take_nominal,
        automatic=classes_named(automatic or ()),
    )
    with busy("following the series"):
        store = opened(db)
        done = series.propose(store, which.book(store, options), options, job)
    if as_json:
        found = [proposal_as_dict(one, done.book.verdict(one)) for one in done.proposals]
        print_json({"part_type": done.book.part_type, "proposals": found, "waiting": list(done.not_accepted)})
        return
    print_lines([f"{done.book.part_type}: {len(done.proposals)} proposals, {len(done.new)} of them new"])
    for one in done.proposals:
        print_lines(["", *proposal_lines(one, done.book.verdict(one))])
    print_lines(["", *done.not_accepted] if done.not_accepted else [])


@dataclass(frozen=True, kw_only=True)
class Offset:
    """Where the tool offset is to be written."""

    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="File for the tool offset.  [default: none is written]")
    ] = None
    control: Annotated[
        Control | None,
        typer.Option("--control", help="Write the offset in this control's words.  [default: the job's]"),
    ] = None
    table: Annotated[
        Path | None, typer.Option("--table", help="Write a copy of this tool table with the offset in it.")
    ] = None
    table_unit: Annotated[
        Literal["mm", "inch"] | None, typer.Option("--table-unit", help="Unit of a table that does not say its own.")
    ] = None
    x_is: Annotated[
        Literal["radius", "diameter"] | None,
        typer.Option("--x-is", help="How the control counts offsets on X.  [default: as the job's program]"),
    ] = None

    def where(self) -> "Written | None":
        """As a job takes it; None: nowhere."""
        from trueloop.jobs.series.proposed import Written

        if self.output is None:
            if self.control is not None or self.table is not None:
                raise typer.BadParameter("name the file to write", param_hint="--output")
            return None
        if self.control is not None and self.table is not None:
            raise typer.BadParameter("give one of --control and --table", param_hint="--output")
        return Written(self.output, self.control, self.table, self.table_unit, self.x_is)


@guarded
def accept(
    proposal: Id,
    offset: Offset,
    who: Who = None,
    why: Why = "",
    override: Annotated[
        list[Override] | None,
        typer.Option("--override", help="Accept in spite of this; several times.  [default: nothing]"),
    ] = None,
    max_um: Annotated[
        float, typer.Option("--max-um", callback=positive, help="A larger change is refused.")
    ] = LARGEST_UM,
    max_age_h: Annotated[
        float, typer.Option("--max-age-h", callback=positive, help="A proposal made longer ago is refused.")
    ] = AGE_H,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Accept a proposal: from now on parts are taken as cut with it. Writes its tool offset where that is asked for."""
    from trueloop.jobs.series.proposed import accepted
    from trueloop.jobs.store.opened import opened
    from trueloop.loops.post_process.options import SeriesOptions

    options = SeriesOptions(largest_mm=max_um / UM_PER_MM, age_hours=max_age_h)
    found, decision, file = accepted(
        opened(db), proposal, options, offset.where(), who=who or "", why=why, override=override or ()
    )
    _say(found, decision, as_json, None if file is None else str(file))


@guarded
def reject(proposal: Id, who: Who = None, why: Why = "", db: Db = None, as_json: AsJson = False) -> None:
    """Reject a proposal: it is kept with who rejected it, and why."""
    from trueloop.jobs.series.proposed import rejected
    from trueloop.jobs.store.opened import opened

    found, decision = rejected(opened(db), proposal, who=who or "", why=why)
    _say(found, decision, as_json, None)


def _say(proposal: "Proposal", decision: "ProposalDecision", as_json: bool, file: str | None) -> None:
    from trueloop.report.series.lines import proposal_as_dict, proposal_lines

    if as_json:
        print_json({**proposal_as_dict(proposal, decision), "file": file})
        return
    print_lines(proposal_lines(proposal, decision))
    if file is not None:
        typer.echo(f"written: {file}", err=True)
