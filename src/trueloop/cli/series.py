"""`trueloop series`: finished parts as inspected, what was expected of them, and proposals for the next part."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from trueloop.cli.shared_options import Control, Db, Page, argument, option, positive
from trueloop.cli.terminal import AsJson, Group, busy, finding_lines, print_files, print_json, print_lines, print_table
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.domain.proposal import Proposal, ProposalDecision
    from trueloop.factory.book import Book
    from trueloop.jobs.series import AddedFile, Written
    from trueloop.loops.post_process.series import SeriesOptions
    from trueloop.report.series.values import SeriesShape
    from trueloop.storage.store import Store

Files = Annotated[list[Path], argument("Files of a gauge or a measuring machine, of finished parts.", metavar="FILE…")]
NONE = "none"


@dataclass(frozen=True, kw_only=True)
class FileFacts:
    """Facts that the files do not state."""

    part_type: Annotated[
        str | None, option("Name of the part type.  [default: as the file states]", "--type", "-t")
    ] = None
    serial: Annotated[str | None, option("Serial number, of a file of one part without.")] = None
    unit: Annotated[Literal["mm", "inch"] | None, option("Unit of its lengths.  [default: as it states]")] = None
    mapping: Annotated[Path | None, option("TOML file that states what columns and names mean.", "--mapping", "-m")] = (
        None
    )
    take_nominal: Annotated[
        bool, option("Do not flag parts whose values are exactly nominal as left out.", "--take-nominal")
    ] = False
    cut_with: Annotated[
        list[str] | None,
        option(
            "An accepted proposal that was in force when the parts were cut, several times; `none`: no proposal "
            "was.  [default: all that were accepted before]",
            metavar="ID",
        ),
    ] = None


def add(files: Files, facts: FileFacts, db: Db = None, as_json: AsJson = False) -> None:
    """Store inspections of finished parts, each file whole.

    A file that is wrong anywhere is not stored.
    """
    from trueloop.formats.inspections.measured_file import StatedFacts
    from trueloop.jobs.series import Adding, add_inspections
    from trueloop.jobs.store.opened import open_store

    cut_with = None if facts.cut_with is None else tuple(one for one in facts.cut_with if one != NONE)
    adding = Adding(
        facts.part_type or "", facts.serial or "", StatedFacts(facts.unit, facts.mapping), facts.take_nominal, cut_with
    )
    with busy(f"reading {', '.join(map(str, files))}"):
        added = add_inspections(open_store(db), files, adding)
    if as_json:
        print_json({"files": [_as_dict(added_file) for added_file in added]})
    else:
        for added_file in added:
            lines = [
                f"{added_file.path}: {added_file.part_type}, {len(added_file.new)} parts kept, {added_file.sizes} sizes"
            ]
            if added_file.known:
                lines.append(f"  {len(added_file.known)} parts are in the store already: {', '.join(added_file.known)}")
            if added_file.cut_with:
                lines.append(f"  cut with the proposals {', '.join(added_file.cut_with)}")
            print_lines([*lines, *added_file.findings])


def _as_dict(one: "AddedFile") -> dict[str, object]:
    findings = [{"code": f.code, "severity": f.severity, "message": f.message, "hint": f.hint} for f in one.findings]
    return {
        "file": str(one.path),
        "part_type": one.part_type,
        "new": list(one.new),
        "known": list(one.known),
        "cut_with": list(one.cut_with),
        "sizes": one.sizes,
        "findings": findings,
    }


LARGEST_UM: Final = 150.0
LEAST_UM: Final = 0.5
AGE_H: Final = 168.0
"""As `SeriesOptions` has them; a test compares."""


@dataclass(frozen=True, kw_only=True)
class Which:
    """Selects the series."""

    part_type: Annotated[str | None, option("The part type.  [default: the only one in the store]", "--type", "-t")] = (
        None
    )
    characteristic: Annotated[
        list[str] | None,
        option("Of this characteristic alone; several times.  [default: all]", "--characteristic", "-c"),
    ] = None
    take_nominal: Annotated[
        bool, option("Use parts whose values are exactly nominal, as if filled in.", "--take-nominal")
    ] = False

    def book(self, store: "Store", options: "SeriesOptions") -> "Book":
        """The series asked for. Raises SER-UNKNOWN."""
        from trueloop.factory.book import only_type, read_book

        return read_book(store, self.part_type or only_type(store), options).named(self.characteristic or ())


class Class(StrEnum):
    """Classes of proposals, as `trueloop.loops.post_process.series.NAMES` has them; a test compares."""

    OFFSET = "offset"
    MEMORY = "memory"
    WEIGHT = "weight"


class Override(StrEnum):
    """Refusals that may be overridden, as `trueloop.loops.post_process.decide.OVERRIDES` has them; a test compares."""

    LARGE = "large"
    OLD = "old"
    SUPERSEDED = "superseded"
    ALARM = "alarm"


Id = Annotated[str, argument("The proposal's id, or its beginning.", metavar="ID")]
Who = Annotated[str | None, option("Who decides.  [default: the user's name]", "--who")]
Why = Annotated[str, option("For the record.", "--why")]


def propose(
    which: Which,
    job: Annotated[
        Path | None, option("The job whose tool cuts the part: the offsets of its tool, dX and dZ.", "--job", "-j")
    ] = None,
    min_um: Annotated[float, option("Smaller changes are not proposed.", min=0.0)] = LEAST_UM,
    automatic: Annotated[
        list[Class] | None, option("Accept proposals of this class at once; several times.  [default: none]")
    ] = None,
    max_um: Annotated[float, option("A larger change is not accepted at once.", callback=positive)] = LARGEST_UM,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Propose changes for the next part: offsets, weights.

    After an alarm also memory begun anew.
    """
    from trueloop.jobs import series
    from trueloop.jobs.store.opened import open_store
    from trueloop.loops.post_process.series import SeriesOptions, classes_named
    from trueloop.report.series.lines import proposal_as_dict, proposal_lines

    options = SeriesOptions(
        largest_mm=max_um / UM_PER_MM,
        least_mm=min_um / UM_PER_MM,
        take_nominal=which.take_nominal,
        automatic=classes_named(automatic or ()),
    )
    with busy("following the series"):
        store = open_store(db)
        done = series.propose(store, which.book(store, options), options, job)
    if as_json:
        found = [proposal_as_dict(proposal, done.book.verdict(proposal)) for proposal in done.proposals]
        print_json({"part_type": done.book.part_type, "proposals": found, "waiting": list(done.not_accepted)})
        return
    print_lines([f"{done.book.part_type}: {len(done.proposals)} proposals, {len(done.new)} of them new"])
    for proposal in done.proposals:
        print_lines(["", *proposal_lines(proposal, done.book.verdict(proposal))])
    print_lines(["", *done.not_accepted] if done.not_accepted else [])


@dataclass(frozen=True, kw_only=True)
class Offset:
    """Where the tool offset is to be written."""

    output: Annotated[
        Path | None, option("File for the tool offset.  [default: none is written]", "--output", "-o")
    ] = None
    control: Annotated[Control | None, option("Write the offset in this control's words.  [default: the job's]")] = None
    table: Annotated[Path | None, option("Write a copy of this tool table with the offset in it.")] = None
    table_unit: Annotated[Literal["mm", "inch"] | None, option("Unit of a table that does not state its own.")] = None
    x_is: Annotated[
        Literal["radius", "diameter"] | None,
        option("Offsets on X at the control: radius or diameter.  [default: as the job's program]"),
    ] = None

    def where(self) -> "Written | None":
        """As a job takes it; None: nowhere."""
        from trueloop.jobs.series import Written

        if self.output is None:
            if self.control is not None or self.table is not None:
                raise typer.BadParameter("name the file to write", param_hint="--output")
            return None
        if self.control is not None and self.table is not None:
            raise typer.BadParameter("give one of --control and --table", param_hint="--output")
        return Written(self.output, self.control, self.table, self.table_unit, self.x_is)


def accept(
    proposal: Id,
    offset: Offset,
    who: Who = None,
    why: Why = "",
    override: Annotated[
        list[Override] | None, option("Accept in spite of this; several times.  [default: nothing]")
    ] = None,
    max_um: Annotated[float, option("A larger change is refused.", callback=positive)] = LARGEST_UM,
    max_age_h: Annotated[float, option("A proposal made longer ago is refused.", callback=positive)] = AGE_H,
    db: Db = None,
    as_json: AsJson = False,
) -> None:
    """Accept a proposal: from now on parts are taken as cut with it. Writes its tool offset where that is requested."""
    from trueloop.jobs.series import accepted
    from trueloop.jobs.store.opened import open_store
    from trueloop.loops.post_process.series import SeriesOptions

    options = SeriesOptions(largest_mm=max_um / UM_PER_MM, age_hours=max_age_h)
    found, decision, file = accepted(
        open_store(db), proposal, options, offset.where(), who=who or "", why=why, override=override or ()
    )
    _say(found, decision, as_json, None if file is None else str(file))


def reject(proposal: Id, who: Who = None, why: Why = "", db: Db = None, as_json: AsJson = False) -> None:
    """Reject a proposal: it is kept with who rejected it, and why."""
    from trueloop.jobs.series import rejected
    from trueloop.jobs.store.opened import open_store

    found, decision = rejected(open_store(db), proposal, who=who or "", why=why)
    _say(found, decision, as_json, None)


def _say(proposal: "Proposal", decision: "ProposalDecision", as_json: bool, file: str | None) -> None:
    from trueloop.report.series.lines import proposal_as_dict, proposal_lines

    if as_json:
        print_json({**proposal_as_dict(proposal, decision), "file": file})
        return
    print_lines(proposal_lines(proposal, decision))
    if file is not None:
        typer.echo(f"written: {file}", err=True)


Output = Annotated[
    Path | None, option("Folder for the page, the values and the table.  [default: none]", "--output", "-o")
]


def status(which: Which, page: Page, output: Output = None, db: Db = None, as_json: AsJson = False) -> None:
    """Show each characteristic: level, drift, alarms, proposal.

    Also parts, last error, the level's band and weight.
    """
    from trueloop.jobs.series import status_of
    from trueloop.jobs.store.opened import open_store
    from trueloop.loops.post_process.series import SeriesOptions
    from trueloop.report.series.lines import HEAD, proposal_lines, status_rows

    options = SeriesOptions(take_nominal=which.take_nominal)
    with busy("following the series"):
        book = which.book(open_store(db), options)
        shown = status_of(book, options)
        files = _written(shown, "series", output, page)
    if as_json:
        print_json({**shown.model_dump(mode="json"), "files": files})
        return
    print_lines([f"{shown.part_type}: {shown.parts} parts, {len(shown.characteristics)} characteristics"])
    print_table(HEAD, status_rows(shown))
    for proposal in book.waiting:
        print_lines(["", *proposal_lines(proposal, None)])
    _print_rest(shown, files)


def replay(which: Which, page: Page, output: Output = None, db: Db = None, as_json: AsJson = False) -> None:
    """Go through the stored parts: proposals and their effect.

    In order; the effect is what each proposal would have left.
    """
    from trueloop.jobs.series import replay_of
    from trueloop.jobs.store.opened import open_store
    from trueloop.loops.post_process.series import SeriesOptions

    options = SeriesOptions(take_nominal=which.take_nominal)
    with busy("replaying the series"):
        shown = replay_of(which.book(open_store(db), options))
        files = _written(shown, "replay", output, page)
    _print_replay(shown, f"{shown.part_type}: {shown.parts} parts", files, as_json)


@dataclass(frozen=True, kw_only=True)
class Shop:
    """Settings of the simulated shop."""

    parts: Annotated[int, option("Number of parts.", min=2, max=10_000)] = 30
    seed: Annotated[int, option("Another number gives another series.", min=0)] = 0
    gain: Annotated[float, option("Share of a correction that arrives: 2 is twice as much.")] = 1.0
    tool_changed_at: Annotated[int | None, option("Part before which the edge is changed, as is known.", min=2)] = None
    jump_at: Annotated[int | None, option("Part from which on an offset acts that nobody knows of.", min=2)] = None
    jump_um: Annotated[float, option("That offset, on the radius.")] = 20.0


def simulate(shop: Shop, page: Page, output: Output = None, as_json: AsJson = False) -> None:
    """Simulate a series that wears and warms up.

    What memory leaves, beside no correction and simpler rules.
    """
    from trueloop_lab.loops.series import simulated

    with busy(f"simulating {shop.parts} parts"):
        shown = simulated(**vars(shop))
        files = _written(shown, "simulation", output, page)
    _print_replay(shown, f"{shown.parts} simulated parts", files, as_json)


def _written(shown: "SeriesShape", name: str, folder: Path | None, page: Page) -> list[str]:
    from trueloop.report.markup import write_page
    from trueloop.report.series.lines import series_csv
    from trueloop.report.series.page import series_page

    return write_page(shown, name, series_page, folder, page.language, page.unit, csv=series_csv(shown))


def _print_replay(shown: "SeriesShape", of: str, files: list[str], as_json: bool) -> None:
    from trueloop.report.series.lines import replay_rows

    if as_json:
        print_json({**shown.model_dump(mode="json"), "files": files})
        return
    print_lines([f"{of}; root mean square left from the second part on, µm"])
    head, *rows = replay_rows(shown)
    print_table(head, rows)
    _print_rest(shown, files)


def _print_rest(shown: "SeriesShape", files: list[str]) -> None:
    found = finding_lines(shown.findings)
    print_lines([*([""] if found else []), *found])
    print_files(files)


app = Group("Series of finished parts: inspections, proposed offsets.")
app.add_all(add, status, propose, accept, reject, replay, simulate)
