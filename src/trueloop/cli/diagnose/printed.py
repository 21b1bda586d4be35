"""How a diagnosis is printed: its lines, what is odd, the files written."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import typer

from trueloop.cli.terminal import print_json, print_lines

if TYPE_CHECKING:
    from trueloop.report.series.shapes import FindingShape
    from trueloop.report.shape import Shape


def print_diagnosis(
    found: "Shape", lines: Iterable[str], findings: "Iterable[FindingShape]", files: list[str], *, as_json: bool
) -> None:
    """As JSON with the files' names, or as lines."""
    if as_json:
        print_json({**found.model_dump(mode="json"), "files": files})
        return
    print_lines([*lines])
    print_lines([f"{one.severity} {one.code}: {one.message}\n  hint: {one.hint}" for one in findings])
    for file in files:
        typer.echo(f"written: {file}", err=True)
