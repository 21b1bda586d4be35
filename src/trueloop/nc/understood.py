"""A program that shall be changed must be understood whole: what is skipped might move the tool."""

from typing import Final

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program import Program

NOT_UNDERSTOOD: Final = frozenset({Code.NC_WORD, Code.NC_CODE})


def require_understood(program: Program) -> None:
    """Raises NC-WORD or NC-CODE for the first word or code that the dialect does not know, with how many there are."""
    found = [finding for finding in program.findings if finding.code in NOT_UNDERSTOOD]
    if found:
        first, more = found[0], len(found) - 1
        raise TrueloopError(
            first.code,
            first.message + (f", and {more} more that {program.dialect.name} does not know" if more else ""),
            hint=f"{first.hint}; `trueloop nc check` lists them all",
            place=first.place,
            override="programs.accept_unknown_words in the job",
        )
