"""A machine's model diagnosed: which axis errors it has wrong, from what it left on many parts."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.diagnosis.frames import LEAST_PARTS, Frames, reconcile_frames
from trueloop.diagnosis.terms.judge import Correlation, Verdict, judge, one_after_another
from trueloop.diagnosis.terms.suspects import Residuals
from trueloop.errors import Finding
from trueloop.loops.diagnosis.left_on_parts import BothSeen, checked, element_signals, residuals
from trueloop.machine.model.model import MachineModel


@dataclass(frozen=True, eq=False)
class MachineDiagnosis:
    """The diagnosis of one model: `parts` are those that were used, in the order of the residuals' numbers.

    `frames` says how the part frames of both devices lie to each other; None for a single part.
    `own_way`: what one correlation after another names [4773 §3.3], for comparison.
    """

    parts: tuple[BothSeen, ...]
    seen: Residuals
    verdict: Verdict
    frames: Frames | None
    own_way: tuple[Correlation, ...]
    findings: tuple[Finding, ...]


def diagnose_machine(
    model: MachineModel, parts: Sequence[BothSeen], element: Mapping[str, str], accept: Collection[str] = ()
) -> MachineDiagnosis:
    """Diagnoses a machine by parts in the order in which they were cut; `element` as `element_signals` takes it.

    Where the frame of a part was found anew on the measuring machine it may be turned as well as moved. Raises DIA-FEW,
    DIA-SIGNAL, DIA-PART, DIA-MOVED, DIA-POINTS, DIA-NONE.
    """
    usable, odd = checked(model, parts, accept)
    kept, seen, missing = residuals(model, usable, element_signals(model, element), accept)
    verdict = judge(model.machine.chain, seen, turned=any(part.new_frame for part in kept))
    frames = _frames(kept, seen, verdict.noise_mm)
    own_way = one_after_another(model.machine.chain, seen)
    moved = () if frames is None else frames.findings
    return MachineDiagnosis(kept, seen, verdict, frames, own_way, (*odd, *missing, *moved, *verdict.notes))


def _frames(parts: Sequence[BothSeen], seen: Residuals, u_mm: float) -> Frames | None:
    """Returns the differences of CMM and machine as motions of the part frames [6876 §3.1]."""
    if len(parts) < LEAST_PARTS:
        return None
    nominal_mm = np.concatenate([part.seen.nominal_mm for part in parts])
    names = [part.serial for part in parts]
    return reconcile_frames(seen.part, nominal_mm, seen.normal, seen.residual_mm, u_mm, names)
