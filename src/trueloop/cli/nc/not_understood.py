"""What a program's path leaves out, said beside what was made of the path."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import typer

from trueloop.errors import Code, Finding, Severity

if TYPE_CHECKING:
    from trueloop.nc.program.program import Program
    from trueloop.nc.program.tool_path import ToolPath

PATH_MAY_DIFFER: Final = (Code.NC_CODE, Code.NC_WORD, Code.NC_OPAQUE, Code.NC_UNIT, Code.NC_DIAMETER)
"""Warnings after which the machine may go elsewhere than the path does."""


def not_understood(program: "Program", path: "ToolPath") -> list[Finding]:
    """The warnings of a program after which its path may not be the machine's, in the order of the blocks."""
    return path_may_differ((*program.findings, *path.findings))


def path_may_differ(findings: Sequence[Finding]) -> list[Finding]:
    """Those of the findings, in the order of the blocks."""
    found = [one for one in findings if one.severity is Severity.WARNING and one.code in PATH_MAY_DIFFER]
    return sorted(found, key=lambda one: (one.place.line or 0, one.place.column or 0))


def tell_not_understood(program: "Program", path: "ToolPath") -> None:
    """Says the first of them on stderr, and how many there are."""
    tell(not_understood(program, path), program.file)


def tell(found: Sequence[Finding], file: str | None) -> None:
    """The same of those that are known already."""
    if not found:
        return
    typer.echo(str(found[0]), err=True)
    if len(found) > 1:
        others = f"{file or 'program'}: {len(found) - 1} more of this kind"
        typer.echo(f"{others}: the machine may go elsewhere\n  hint: `trueloop nc check` lists them", err=True)
