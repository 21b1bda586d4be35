"""What `compensate` and `demo` say in the end: before, predicted after, why, and where the files are."""

from collections.abc import Sequence
from pathlib import Path

from trueloop.cli.terminal import wide_console
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.outcome import between_cuts_words
from trueloop.report.style import plain, signed
from trueloop.report.turned.by_tool import by_tool_lines
from trueloop.report.turned.characteristics import characteristics_words
from trueloop.report.turned.composed import composed_words
from trueloop.report.turned.features import feature_summaries
from trueloop.report.turned.figures.uncertainty import budget_words
from trueloop.report.turned.summary import headline, offset_words


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
    for words in (correction.decision.x.words, correction.decision.z.words, *correction.notes):
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
