"""What a cell decides, in every situation that there is: nothing is begun twice, and what was seen is told."""

from hypothesis import given
from hypothesis import strategies as st

from trueloop.controllers.linuxcnc.cell.decide import (
    ControlNow,
    Do,
    Doing,
    Patience,
    ProgramCounts,
    ServiceState,
    decide,
    seen,
)
from trueloop.controllers.linuxcnc.cell.journal import RunNow
from trueloop.domain.factory import FactKind

KEY = "O1.1.0.1"
FLAGS = st.booleans()
RUNS = st.builds(
    RunNow,
    *(st.just(KEY), st.just("a" * 64), st.sampled_from(["", "touches.txt"]), st.frozensets(st.sampled_from(FactKind))),
    *(FLAGS, FLAGS, FLAGS, FLAGS, FLAGS),
)
CONTROLS = st.builds(
    ControlNow, st.sampled_from(Doing), st.sampled_from(["", f"{KEY}.ngc", "other.ngc"]), st.floats(0, 100)
)
WITNESSES = st.builds(ProgramCounts, st.integers(0, 2), st.integers(0, 2))
ASKED = st.builds(ServiceState, st.sampled_from(["", KEY, "O1.1.0.2"]), FLAGS, st.sampled_from([None, b"M2\n"]))
MOVED = {FactKind.STARTED, FactKind.ENDED, FactKind.UNKNOWN}
_SITUATIONS = given(RUNS, CONTROLS, WITNESSES, ASKED)


@_SITUATIONS
def test_motion_begins_only_where_nothing_ever_began(
    run: RunNow, now: ControlNow, log: ProgramCounts, asked: ServiceState
) -> None:
    if decide(run, now, log, asked, Patience()).do is Do.BEGIN:
        assert not run.begun and not run.facts & MOVED and not log.started and not log.ended
        assert FactKind.VERIFIED in run.facts and not run.differs and not run.withdrawn
        assert asked.armed and asked.key == KEY
        assert now.doing is Doing.IDLE and now.program == f"{KEY}.ngc"


@_SITUATIONS
def test_nothing_is_loaded_or_taken_away_while_a_program_runs(
    run: RunNow, now: ControlNow, log: ProgramCounts, asked: ServiceState
) -> None:
    action = decide(run, now, log, asked, Patience())
    if now.active and now.program == f"{KEY}.ngc":
        assert action.do in (Do.TELL, Do.WAIT, Do.GATHER)
    if now.active:
        assert action.do not in (Do.OPEN, Do.BEGIN)


@_SITUATIONS
def test_what_the_program_says_is_told_before_anything_else(
    run: RunNow, now: ControlNow, log: ProgramCounts, asked: ServiceState
) -> None:
    action = decide(run, now, log, asked, Patience())
    if log.started == 1 and log.ended and FactKind.ENDED not in run.facts:
        assert action.do is Do.TELL and action.fact in (FactKind.STARTED, FactKind.ENDED)
    if FactKind.STARTED in run.facts and not run.facts & {FactKind.ENDED, FactKind.UNKNOWN} and not log.ended:
        assert action.do in (Do.TELL, Do.WAIT)
        assert action.fact in (None, FactKind.UNKNOWN)


@_SITUATIONS
def test_decisions_come_to_an_end(run: RunNow, now: ControlNow, log: ProgramCounts, asked: ServiceState) -> None:
    """A fact is told once: noted, it is not decided on again."""
    from dataclasses import replace

    for _ in range(5):
        action = decide(run, now, log, asked, Patience())
        if action.do is not Do.TELL:
            return
        assert action.fact is not None and action.fact not in run.facts
        run = replace(run, facts=run.facts | {action.fact})
    raise AssertionError("it tells for ever")


def test_a_line_that_is_being_written_is_not_read() -> None:
    assert seen("a started\na ended\nb started\nb end", "b") == ProgramCounts(1, 0)
    assert seen("b started\nb ended", "b") == ProgramCounts(1, 0)
    assert seen("ab started\n", "b") == ProgramCounts(0, 0)
