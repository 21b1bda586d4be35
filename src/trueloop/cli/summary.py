"""The summary of a correction on the terminal: of one edge, and of a part with several."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from trueloop.cli.terminal import wide_console
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
