"""Refusals of both loops before anything is computed: a correction twice, of another program, from old measurements."""

from datetime import datetime

from trueloop.domain.option import Limits, check_age
from trueloop.domain.record import check_same_program, check_uncorrected
from trueloop.errors import in_file
from trueloop.nc.program.program import Program
from trueloop.wording import wording


def refuse_misuse(
    program: Program | None, program_sha256: str | None, measured_at: datetime | None, now: datetime, limits: Limits
) -> list[str]:
    """Raises CMP-TWICE, CMP-OTHER-PROGRAM and CMP-AGE; returns notes on what could not be checked."""
    if program is not None:
        with in_file(program.file):
            check_uncorrected(program.source)
            if program_sha256 is not None:
                check_same_program(program.source, program_sha256)
    if measured_at is None:
        return [wording("The job does not say when the part was touched, so the touches' age was not checked.")]
    check_age(measured_at, now, limits)
    return []
