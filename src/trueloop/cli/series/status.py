"""`trueloop series status` and `replay`: the series as they are, and as they would have been with memory."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded
from trueloop.cli.series.options import Page, Which
from trueloop.cli.terminal import AsJson, busy, print_json, print_lines, print_table

if TYPE_CHECKING:
    from trueloop.report.series.shapes import SeriesShape

Output = Annotated[
    Path | None, typer.Option("--output", "-o", help="Folder for the page, the values and the table.  [default: none]")
]


@guarded
def status(which: Which, page: Page, output: Output = None, db: Db = None, as_json: AsJson = False) -> None:
    """Show each characteristic: parts, last error, level with its band, weight, drift, alarms, what is proposed."""
    from trueloop.jobs.series.pages import status_of, write_series
    from trueloop.jobs.store.opened import opened
    from trueloop.loops.post_process.options import SeriesOptions
    from trueloop.report.series.lines import HEAD, proposal_lines, status_rows

    options = SeriesOptions(take_nominal=which.take_nominal)
    with busy("following the series"):
        book = which.book(opened(db), options)
        shown = status_of(book, options)
        files = write_series(shown, "series", output, page.language, page.unit)
    if as_json:
        print_json({**shown.model_dump(mode="json"), "files": files})
        return
    print_lines([f"{shown.part_type}: {shown.parts} parts, {len(shown.characteristics)} characteristics"])
    print_table(HEAD, status_rows(shown))
    for proposal in book.waiting:
        print_lines(["", *proposal_lines(proposal, None)])
    _print_rest(shown, files)


@guarded
def replay(which: Which, page: Page, output: Output = None, db: Db = None, as_json: AsJson = False) -> None:
    """Go through the stored parts in order: what would have been proposed for each, and what that would have left."""
    from trueloop.jobs.series.pages import replay_of, write_series
    from trueloop.jobs.store.opened import opened
    from trueloop.loops.post_process.options import SeriesOptions

    options = SeriesOptions(take_nominal=which.take_nominal)
    with busy("replaying the series"):
        shown = replay_of(which.book(opened(db), options))
        files = write_series(shown, "replay", output, page.language, page.unit)
    _print_replay(shown, f"{shown.part_type}: {shown.parts} parts", files, as_json)


@dataclass(frozen=True, kw_only=True)
class Shop:
    """What is simulated."""

    parts: Annotated[int, typer.Option("--parts", min=2, max=10_000, help="How many parts.")] = 30
    seed: Annotated[int, typer.Option("--seed", min=0, help="Another number gives another series.")] = 0
    gain: Annotated[float, typer.Option("--gain", help="Share of a correction that arrives: 2 is twice as much.")] = 1.0
    tool_changed_at: Annotated[
        int | None, typer.Option("--tool-changed-at", min=2, help="Part before which the edge is changed, as is known.")
    ] = None
    jump_at: Annotated[
        int | None, typer.Option("--jump-at", min=2, help="Part from which on an offset acts that nobody knows of.")
    ] = None
    jump_um: Annotated[float, typer.Option("--jump-um", help="That offset, on the radius.")] = 20.0


@guarded
def simulate(shop: Shop, page: Page, output: Output = None, as_json: AsJson = False) -> None:
    """Simulate a series that wears and warms up: what memory leaves, beside doing nothing and simpler rules."""
    from trueloop.jobs.series.pages import WhatIf, simulated, write_series

    with busy(f"simulating {shop.parts} parts"):
        given = WhatIf(shop.parts, shop.seed, shop.gain, shop.tool_changed_at, shop.jump_at, shop.jump_um)
        shown = simulated(given)
        files = write_series(shown, "simulation", output, page.language, page.unit)
    _print_replay(shown, f"{shown.parts} simulated parts", files, as_json)


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
    found = [f"{one.severity} {one.code}: {one.message}\n  hint: {one.hint}" for one in shown.findings]
    print_lines([*([""] if found else []), *found])
    for file in files:
        typer.echo(f"written: {file}", err=True)
