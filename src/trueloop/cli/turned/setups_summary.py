"""What `compensate` says of a part with several set-ups: the answers, every feature, what to run."""

from collections.abc import Sequence
from pathlib import Path

from trueloop.cli.terminal import wide_console
from trueloop.cli.turned.joint_summary import SIGNS, edge_words, feature_rows
from trueloop.loops.turned.setup_corrections import CorrectedSetups
from trueloop.report.turned.setups import all_notes, all_to_do, answers


def print_setups(corrected: CorrectedSetups, files: Sequence[Path]) -> None:
    """The summary for people, on stdout."""
    from rich.markup import escape

    console = wide_console()
    for answer in answers(corrected):
        console.print(f"[bold]{escape(answer)}[/]")
    console.print(f"\n[bold]{escape(corrected.part)}[/], correction {corrected.record_id}\n")
    console.print(feature_rows([(one.frame.name, one.joint) for one in corrected.setups]))
    console.print(f"\n{SIGNS}\n")
    for note in all_notes(corrected):
        console.print(f"- {escape(note)}")
    for one in corrected.setups:
        for words in edge_words(one.joint, f"{one.frame.name}, "):
            console.print(escape(words))
    console.print()
    for words in all_to_do(corrected):
        console.print(f"[bold]{escape(words)}[/]")
    console.print("Written:")
    for path in files:
        console.print(f"  {escape(str(path))}")
