"""`trueloop nc check`: what is odd about a program."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

import typer

from trueloop.cli.failure import ExitStatus, guarded
from trueloop.cli.program_file import ProgramFile, Reading, Tables
from trueloop.cli.terminal import AsJson, busy, print_json, wide_console

if TYPE_CHECKING:
    from trueloop.errors import Finding


@guarded
def check_program(file: ProgramFile, reading: Reading, tables: Tables, as_json: AsJson = False) -> None:
    """Print what is odd about a program, with its place. Exit status 1 when there is an error among it."""
    from trueloop.errors import Severity
    from trueloop.nc.check.check import check

    with busy(f"checking {file}"):
        program, known = reading.program(file), tables.read()
        findings = check(program, reading.parameters, skipped_blocks=reading.skipped_blocks, tools=known.tools)
    errors, dialect = sum(finding.severity is Severity.ERROR for finding in findings), program.dialect.name
    if as_json:
        found = [asdict(finding) for finding in findings]
        print_json({"file": str(file), "dialect": dialect, "errors": errors, "findings": found})
    else:
        _print_findings(findings, f"{dialect} program of {program.block_count} blocks", errors)
    if errors:
        raise typer.Exit(ExitStatus.FINDINGS)


def _print_findings(findings: Sequence["Finding"], of: str, errors: int) -> None:
    from rich.text import Text

    console = wide_console()
    colours = {"error": "bold red", "warning": "yellow", "note": "cyan"}
    for finding in findings:
        text = Text(str(finding))
        text.highlight_words([f"{finding.severity} {finding.code}"], colours[finding.severity])
        console.print(text)
    console.print(f"{of}: {len(findings)} findings, {errors} of them errors", markup=False)
