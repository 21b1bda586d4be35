"""`trueloop compensate`: a job file in; programs, table, record and report out.

The summary of a correction on the terminal: of one edge, and of a part with several.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from trueloop.cli.options import StoreChoice, kept_as_dict, print_findings
from trueloop.cli.shared_options import argument, option
from trueloop.cli.terminal import AsJson, busy, guarded, print_json, wide_console
from trueloop.domain.option import Language, LengthUnit, MemoryUse
from trueloop.formats.examples import example
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.outcome import between_cuts_words
from trueloop.loops.turned.part import EdgeCorrection, PartCorrection, SetupCorrection
from trueloop.report.style import plain, signed
from trueloop.report.turned.characteristic_table import characteristics_words
from trueloop.report.turned.figures.curves import budget_words
from trueloop.report.turned.part import all_notes, all_to_do, answers
from trueloop.report.turned.summary import feature_summaries, headline, offset_words
from trueloop.report.turned.touch_table import by_tool_lines, composed_words

if TYPE_CHECKING:
    from rich.table import Table

    from trueloop.jobs.store.opened import Keeping


SIGNS: Final = (
    "+ is material left on. Predicted: what repeats is taken out; ±U holds what the finish cut may differ by."
)


def print_part(corrected: PartCorrection, files: Sequence[Path]) -> None:
    """The summary for people, on stdout."""
    from rich.markup import escape

    console, named = wide_console(), corrected.in_setups
    for answer in answers(corrected):
        console.print(f"[bold]{escape(answer)}[/]")
    console.print(f"\n[bold]{escape(corrected.part)}[/], correction {corrected.record_id}\n")
    console.print(_features(corrected))
    console.print(f"\n{SIGNS}\n")
    for note in all_notes(corrected):
        console.print(f"- {escape(note)}")
    for setup in corrected.setups:
        for words in _edge_words(setup):
            console.print(escape(words))
    console.print()
    *others, last = all_to_do(corrected)
    for words in others:
        console.print(f"[bold]{escape(words)}[/]")
    console.print(f"[bold]{escape(last)}[/]", end="\n" if named else " ")
    console.print("Written:")
    for path in files:
        console.print(f"  {escape(str(path))}")


def _features(corrected: PartCorrection) -> "Table":
    """Every feature of all edges; with the set-up's name where there are several set-ups, in whose order they come."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    named = len(corrected.setups) > 1
    words = ("set-up", "feature", "tool", "correction")
    for heading in ("set-up", "feature", "tool", "touches", "before\nworst µm", "predicted\nworst", "\n±U (95 %)",
                    "correction")[not named :]:  # fmt: skip
        table.add_column(heading, justify="left" if heading in words else "right", no_wrap=True)
    for setup in corrected.setups:
        for of in setup.edges:
            for row in _rows(of):
                table.add_row(*((setup.frame.name, *row) if named else row))
    return table


def _rows(of: EdgeCorrection) -> Iterator[tuple[str, ...]]:
    if of.correction is None:
        words = "left as programmed" if of.kept is None else f"correction {of.kept.id} stays in force"
        for feature in of.features:
            yield feature, of.tool, "0", "", "", "", f"not measured: {words}"
        return
    for line in feature_summaries(of.correction):
        shown = signed(line.figures.before_worst_um), signed(line.expected_um), plain(line.expanded_u_um)
        yield line.feature, of.tool, str(line.figures.touches), *shown, line.correction


def _edge_words(setup: SetupCorrection) -> Iterator[str]:
    """Decisions and notes of every edge of a set-up, and the sizes that were judged."""
    before = f"{setup.frame.name}, " if setup.frame.name else ""
    for of in setup.edges:
        if of.correction is not None:
            for words in (*of.correction.decision.words, *of.correction.notes):
                yield f"- {before}{of.tool}: {words}"
            yield from characteristics_words(of.correction.characteristics)
    yield from characteristics_words(setup.characteristics)


def print_summary(correction: Correction, files: Sequence[Path]) -> None:
    """The summary for people, on stdout."""
    from rich.table import Table

    console = wide_console()
    table = Table(box=None, pad_edge=False)
    table.add_column("feature", no_wrap=True)
    table.add_column("touches", justify="right")
    for heading in ("before\nRMS µm", "\nworst", "predicted\nRMS µm", "\nworst", "\n±U (95 %)"):
        table.add_column(heading, justify="right")
    table.add_column("correction")
    for line in feature_summaries(correction):
        touched = line.figures
        before = plain(touched.before_rms_um), signed(touched.before_worst_um)
        after = plain(touched.predicted_rms_um), signed(line.expected_um), plain(line.expanded_u_um)
        table.add_row(line.feature, str(touched.touches), *before, *after, line.correction)
    answer, *more = by_tool_lines(correction) or [""]
    if answer:
        console.print(f"[bold]{_escaped(answer)}[/]")
        console.print("".join(f"  {_escaped(line)}\n" for line in more))
    console.print(f"[bold]{_escaped(correction.part)}[/], correction {correction.record.id}\n")
    console.print(table)
    console.print(
        "\n+ is material left on. Predicted: what repeats is taken out; ±U holds what the finish cut may differ by."
    )
    console.print(f"[bold]{_escaped(headline(correction))}[/]")
    for words in characteristics_words(correction.characteristics):
        console.print(_escaped(words))
    console.print()
    for words in (budget_words(correction), between_cuts_words(correction.options.between_cuts)):
        console.print(f"- {_escaped(words)}")
    for words in (*correction.decision.words, *correction.notes):
        console.print(f"- {_escaped(words)}")
    if correction.composed is not None:
        console.print(f"- {_escaped(composed_words(correction))}")
    console.print(f"\nTool offset: {_escaped(offset_words(correction))}")
    for block in correction.wear.blocks:
        console.print(f"  {_escaped(block)}")
    console.print(f"\nRun [bold]{_escaped(correction.name_to_run)}[/]. Written:")
    for path in files:
        console.print(f"  {_escaped(str(path))}")


def _escaped(text: str) -> str:
    from rich.markup import escape

    return escape(text)


@dataclass(frozen=True, kw_only=True)
class PageChoice:
    """How the report is shown, where that is not to be the job's choice."""

    language: Annotated[Language | None, option("Of the report.  [default: report.language of the job]")] = None
    unit: Annotated[
        LengthUnit | None, option("Of the report.  [default: report.unit of the job, else the program's]")
    ] = None
    pdf: Annotated[bool, option("Print report.pdf besides, by Chromium or Chrome.", "--pdf")] = False


@guarded
def compensate(
    job: Annotated[Path, argument("The job file; docs/job-file.md explains its keys.", metavar="JOB.toml")],
    page: PageChoice,
    store: StoreChoice,
    output: Annotated[
        Path | None, option("Folder for the results.  [default: output.folder of the job]", "--output", "-o")
    ] = None,
    serial: Annotated[str | None, option("Serial number of the part.  [default: part.serial of the job]")] = None,
    memory: Annotated[
        MemoryUse | None, option("Use of the edge's earlier parts.  [default: memory.use of the job]")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Correct a finish program by touches of the semi-finished part.

    Writes corrected.nc, offsets.nc, table.csv, record.json, report.html and report.json: all, or none when anything is
    wrong. A part with a serial number is kept in a store, with what was measured, the programs and the correction, and
    earlier parts of the edge take part: it is trueloop.db beside the job, which is made, where none is named.

    A job with tables [[tools]] gets a table, a record and a report for each edge, and part.json; one with tables
    [[setups]] a corrected program for each set-up too.
    """
    run_job(job, output, page, store.keeping(serial), as_json, memory)


def run_job(
    path: Path,
    output: Path | None,
    page: PageChoice,
    keeping: "Keeping",
    as_json: bool,
    memory: MemoryUse | None = None,
) -> None:
    """Corrects as the job says and prints what was done."""
    with busy(f"correcting as {path.parent.name}/{path.name} says"):
        from trueloop.jobs.turned.compensate import compensate_and_keep
        from trueloop.report.turned.correction_json import correction_as_dict
        from trueloop.report.turned.part import part_as_dict

        done = compensate_and_keep(
            path, output, keeping, language=page.language, unit=page.unit, pdf=page.pdf, memory=memory
        )
    alone, files = done.corrected.alone, [str(file) for file in done.files]
    if as_json:
        shown = part_as_dict(done.corrected) if alone is None else correction_as_dict(alone)
        print_json({**shown, "files": files, **kept_as_dict(done.kept)})
        return
    if alone is None:
        print_part(done.corrected, done.files)
    else:
        print_summary(alone, done.files)
    if done.kept is not None:
        typer.echo(done.kept.words)
        print_findings(done.kept.findings)
    elif keeping.db is not False:
        typer.echo("kept in no store: the part has no serial number (part.serial of the job, or --serial)")


Part = Literal["facetst", "modbas2", "piecs11"]
"""The parts of [6811] that come with trueloop."""


@guarded
def demo(
    page: PageChoice,
    part: Annotated[Part, argument("Which part.")] = "modbas2",
    output: Annotated[Path | None, option("Folder for the results.  [default: out/PART]", "--output", "-o")] = None,
    as_json: AsJson = False,
) -> None:
    """Correct a part that NIST measured in the 1990s.

    From its touches to a corrected program, as a ready job.
    """
    run_job(
        example(f"{part}/job.toml"),
        output or Path("out") / part,
        page,
        StoreChoice(no_store=True).keeping(None),
        as_json,
    )
