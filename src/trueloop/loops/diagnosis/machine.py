"""A machine's model diagnosed: which axis errors it has wrong, from what it left on many parts."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from trueloop.diagnosis.terms.judge import Verdict, judge
from trueloop.diagnosis.terms.residuals import Residuals
from trueloop.errors import Finding
from trueloop.loops.diagnosis.left_on_parts import BothSeen, checked, element_signals, residuals
from trueloop.machine.model.model import MachineModel


@dataclass(frozen=True, eq=False)
class MachineDiagnosis:
    """Of one model: `parts` are those that were used, in the order of the residuals' numbers."""

    parts: tuple[BothSeen, ...]
    seen: Residuals
    verdict: Verdict
    findings: tuple[Finding, ...]


def diagnose_machine(
    model: MachineModel, parts: Sequence[BothSeen], element: Mapping[str, str], accept: Collection[str] = ()
) -> MachineDiagnosis:
    """By parts in the order in which they were cut; `element` as `element_signals` takes it.

    Where the frame of a part was found anew on the measuring machine it may be turned as well as moved. Raises DIA-FEW,
    DIA-SIGNAL, DIA-PART, DIA-MOVED, DIA-POINTS, DIA-NONE.
    """
    usable, odd = checked(model, parts, accept)
    kept, seen, missing = residuals(model, usable, element_signals(model, element), accept)
    verdict = judge(model.machine.chain, seen, turned=any(part.new_frame for part in kept))
    return MachineDiagnosis(kept, seen, verdict, (*odd, *missing, *verdict.notes))
