"""What both loops refuse before anything is computed: a correction twice, of another program, from old measurements."""

from datetime import datetime

from trueloop.compensation.limits import Limits, check_age
from trueloop.compensation.record import check_same_program, check_uncorrected
from trueloop.errors import TrueloopError
from trueloop.nc.program import Program


def refuse_misuse(
    program: Program | None, program_sha256: str | None, measured_at: datetime | None, now: datetime, limits: Limits
) -> list[str]:
    """Raises CMP-TWICE, CMP-OTHER-PROGRAM and CMP-AGE; returns notes on what could not be checked."""
    if program is not None:
        try:
            check_uncorrected(program.source)
            if program_sha256 is not None:
                check_same_program(program.source, program_sha256)
        except TrueloopError as error:
            raise (error.in_file(program.file) if program.file else error) from None
    if measured_at is None:
        return ["The job does not say when the part was touched, so the touches' age was not checked."]
    check_age(measured_at, now, limits)
    return []
