"""What `compensate` says of a part that several edges cut: the answer by tool, every feature, what to run."""

from collections.abc import Sequence
from pathlib import Path

from trueloop.cli.terminal import wide_console
from trueloop.loops.turned.joint import Joint
from trueloop.report.style import plain, signed
from trueloop.report.turned.characteristics import characteristics_words
from trueloop.report.turned.features import feature_summaries
from trueloop.report.turned.joint import answer_words, notes_of, to_do


def print_joint(joint: Joint, name: str, files: Sequence[Path]) -> None:
    """The summary for people, on stdout."""
    from rich.markup import escape
    from rich.table import Table

    console = wide_console()
    table = Table(box=None, pad_edge=False)
    for heading in ("feature", "tool", "touches", "before\nworst µm", "predicted\nworst", "\n±U (95 %)", "correction"):
        table.add_column(
            heading, justify="left" if heading in ("feature", "tool", "correction") else "right", no_wrap=True
        )
    for of in joint.edges:
        if of.correction is None:
            for feature in of.contour.profile.names:
                table.add_row(feature, of.tool, "0", "", "", "", "not measured: left as programmed")
            continue
        for line in feature_summaries(of.correction):
            shown = signed(line.figures.before_worst_um), signed(line.expected_um), plain(line.expanded_u_um)
            table.add_row(line.feature, of.tool, str(line.figures.touches), *shown, line.correction)
    console.print(f"[bold]{escape(answer_words(joint))}[/]\n")
    console.print(f"[bold]{escape(joint.part)}[/], correction {joint.record_id}\n")
    console.print(table)
    console.print(
        "\n+ is material left on. Predicted: what repeats is taken out; ±U holds what the finish cut may differ by.\n"
    )
    for note in notes_of(joint):
        console.print(f"- {escape(note)}")
    for of in joint.edges:
        if of.correction is not None:
            decision = of.correction.decision
            for words in (decision.x.words, decision.z.words, *of.correction.notes):
                console.print(f"- {escape(f'{of.tool}: {words}')}")
            for words in characteristics_words(of.correction.characteristics):
                console.print(escape(words))
    for words in characteristics_words(joint.characteristics):
        console.print(escape(words))
    console.print(f"\n[bold]{escape(to_do(joint, name))}[/] Written:")
    for path in files:
        console.print(f"  {escape(str(path))}")
