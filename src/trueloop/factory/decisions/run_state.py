"""How far a step has come by what witnesses say of its run: `state_of`."""

from collections.abc import Iterable

from trueloop.domain.factory.route import BlockKind
from trueloop.domain.factory.run import Run, RunFact
from trueloop.domain.factory.states import FactKind, StepState


def state_of(kind: BlockKind, run: Run, facts: Iterable[RunFact], touches: bool) -> StepState:
    """The state, of all facts at once: in whatever order they arrive, and however often, it is the same.

    A cut is recorded once it ended; gauging once its touches are here too. An end outweighs that nobody knew of one. A
    run that failed after it had started is unknown, for the tool may have cut. `verified` counts only where what was
    read back equals what was sent.
    """
    told = {one.what for one in facts if one.what is not FactKind.VERIFIED}
    if FactKind.ENDED in told:
        return StepState.RECORDED if kind.cuts or touches else StepState.ENDED
    if FactKind.UNKNOWN in told or (FactKind.FAILED in told and FactKind.STARTED in told):
        return StepState.UNKNOWN
    if FactKind.FAILED in told:
        return StepState.FAILED
    if FactKind.STARTED in told:
        return StepState.STARTED
    if verified(run, facts):
        return StepState.VERIFIED
    return StepState.SENT if FactKind.SENT in told else StepState.OFFERED


def verified(run: Run, facts: Iterable[RunFact]) -> bool:
    """Whether a witness read back what was sent, and no one read back anything else."""
    read = [one.values.get("read_back_sha256", "") for one in facts if one.what is FactKind.VERIFIED]
    return bool(read) and all(one == run.sent_sha256 for one in read)


def read_back_otherwise(run: Run, facts: Iterable[RunFact]) -> str | None:
    """The hash of what a control held instead of what was sent; None: no witness read back anything else."""
    read = [one.values.get("read_back_sha256", "") for one in facts if one.what is FactKind.VERIFIED]
    return next((one for one in read if one != run.sent_sha256), None)
