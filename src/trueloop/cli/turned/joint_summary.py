"""What `compensate` says of a part that several edges cut: the answer by tool, every feature, what to run."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

from trueloop.cli.terminal import wide_console
from trueloop.loops.turned.joint import Joint, OfEdge
from trueloop.report.style import plain, signed
from trueloop.report.turned.characteristics import characteristics_words
from trueloop.report.turned.features import feature_summaries
from trueloop.report.turned.joint import answer_words, notes_of, to_do

if TYPE_CHECKING:
    from rich.table import Table


SIGNS: Final = (
    "+ is material left on. Predicted: what repeats is taken out; ±U holds what the finish cut may differ by."
)


def feature_rows(joints: "Sequence[tuple[str, Joint]]") -> "Table":
    """Every feature of all edges; with the set-up's name where there are several set-ups, in whose order they come."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    named = len(joints) > 1
    words = ("set-up", "feature", "tool", "correction")
    for heading in ("set-up", "feature", "tool", "touches", "before\nworst µm", "predicted\nworst", "\n±U (95 %)",
                    "correction")[not named :]:  # fmt: skip
        table.add_column(heading, justify="left" if heading in words else "right", no_wrap=True)
    for name, joint in joints:
        for of in joint.edges:
            for row in _rows(of):
                table.add_row(*((name, *row) if named else row))
    return table


def _rows(of: OfEdge) -> Iterator[tuple[str, ...]]:
    if of.correction is None:
        for feature in of.contour.profile.names:
            yield feature, of.tool, "0", "", "", "", "not measured: left as programmed"
        return
    for line in feature_summaries(of.correction):
        shown = signed(line.figures.before_worst_um), signed(line.expected_um), plain(line.expanded_u_um)
        yield line.feature, of.tool, str(line.figures.touches), *shown, line.correction


def edge_words(joint: Joint, before: str = "") -> Iterator[str]:
    """Decisions and notes of every edge, `before` in front of its name, and the sizes that were judged."""
    for of in joint.edges:
        if of.correction is not None:
            decision = of.correction.decision
            for words in (decision.x.words, decision.z.words, *of.correction.notes):
                yield f"- {before}{of.tool}: {words}"
            yield from characteristics_words(of.correction.characteristics)
    yield from characteristics_words(joint.characteristics)


def print_joint(joint: Joint, name: str, files: Sequence[Path]) -> None:
    """The summary for people, on stdout."""
    from rich.markup import escape

    console = wide_console()
    table = feature_rows([("", joint)])
    console.print(f"[bold]{escape(answer_words(joint))}[/]\n")
    console.print(f"[bold]{escape(joint.part)}[/], correction {joint.record_id}\n")
    console.print(table)
    console.print(f"\n{SIGNS}\n")
    for note in notes_of(joint):
        console.print(f"- {escape(note)}")
    for words in edge_words(joint):
        console.print(escape(words))
    console.print(f"\n[bold]{escape(to_do(joint, name))}[/] Written:")
    for path in files:
        console.print(f"  {escape(str(path))}")
