"""`trueloop record`: what a correction was made from, and what it changed."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.shared_options import argument
from trueloop.cli.terminal import AsJson, Group, print_json

app = Group("Records of corrections: what was corrected, from what, by which model.")


@app.callback()
def _commands() -> None:
    """Makes typer keep the name of a single command."""


@app.command()
def show(
    file: Annotated[Path, argument("A record.json or STEM.record.json.", metavar="RECORD.json")],
    as_json: AsJson = False,
) -> None:
    """Show what was corrected, from what, by which model, within which limits, what was decided, by whom and when."""
    from trueloop.formats.record_file import read_record
    from trueloop.report.record import as_dict, words

    record = read_record(file)
    if as_json:
        print_json(as_dict(record))
        return
    typer.echo(f"Correction {record.id}")
    for heading, lines in words(record):
        typer.echo("\n".join([f"\n{heading}", *(f"  {line}" for line in lines)]))
