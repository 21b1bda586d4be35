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
    from trueloop.formats.program_file import read_source
    from trueloop.nc.check.check import Checked, check, check_in_parts
    from trueloop.nc.program.program import read_program

    with busy(f"checking {file}"):
        source, dialect = read_source(file, reading.dialect)
        tools, skipped, parameters = tables.read().tools, reading.skipped_blocks, reading.parameters
        checked = None
        if not tools:
            checked = check_in_parts(source, dialect, str(file), reading.unit, parameters, skipped_blocks=skipped)
        if checked is None:
            program = read_program(source, dialect, str(file), reading.unit)
            findings = check(program, parameters, skipped_blocks=skipped, tools=tools)
            checked = Checked(findings, program.block_count)
    findings = checked.findings
    errors = sum(finding.severity is Severity.ERROR for finding in findings)
    if as_json:
        found = [asdict(finding) for finding in findings]
        print_json({"file": str(file), "dialect": dialect, "errors": errors, "findings": found})
    else:
        _print_findings(findings, f"{dialect} program of {checked.block_count} blocks", errors)
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
