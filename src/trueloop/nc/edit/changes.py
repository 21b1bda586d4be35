"""Changes of a program as a record lists them, and the refusal of a change that did not come out as intended."""

from collections.abc import Sequence

from trueloop.domain.record import ChangedWord
from trueloop.errors import Code, TrueloopError
from trueloop.nc.edit.edit import Edit
from trueloop.nc.program.program import Program


def changes(program: Program, edits: Sequence[Edit]) -> list[ChangedWord]:
    """Edits as a person reads them, in order."""
    listed: list[ChangedWord] = []
    for edit in sorted(edits, key=lambda edit: edit.start):
        place = program.place(edit.start)
        before = program.source[edit.start : edit.end].decode("latin-1")
        listed.append(ChangedWord(place.line or 0, place.column or 0, before, edit.text))
    return listed


def not_as_intended(message: str) -> TrueloopError:
    """Returns the error CMP-READ-BACK of a written program that does not do what was intended."""
    return Code.CMP_READ_BACK.refusal(
        message, hint="nothing was written; please report the program, this should not happen"
    )
