"""The residuals of a machine's model on many parts, from both inspections of each.

On-machine inspection reports r = s − E_p of a surface that lies s off nominal: the machine stands elsewhere than
it says, by its error while it probed. A measuring machine finds s. So that

    n · (CMM − r) + n · COMP_MTG(T_probing) = n · (E_p − E_model,p),

what the model left, at the positions, the stylus and the temperatures of *probing*, whatever the part was cut under.
That is ERROR_MTG,RESID of [6876 §3.5] as far as the model errs at cutting as it does at probing [6876 footnote 6].

The post-process loop's first step: one part's inspections taken apart into machine, process and what was left.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.components import (
    Components,
    FrameDiscrepancy,
    Inspections,
    error_components,
    fit_frame_discrepancy,
    without_discrepancy,
)
from trueloop.diagnosis.frames import LEAST_PARTS, Frames, reconcile_frames
from trueloop.diagnosis.terms.judge import Correlation, Verdict, judge, one_after_another
from trueloop.diagnosis.terms.suspects import Residuals
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.machine.model.chain import Chain, Vector
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import Signals
from trueloop.machine.model.validity import check_state
from trueloop.units import UM_PER_MM
from trueloop.wording import shell_word

OTHER_PART_MM = 0.2
"""Both devices saw one part: by as much as this no sound machine errs between them."""
MOVED_MM = 0.02
"""The least rigid motion between the part frames of both devices of a moved part, where neither was found anew."""
MOVED_SHARE = 3.0
"""The criterion that it is rigid: differences fall to this fraction when the motion is taken out."""


@dataclass(frozen=True, eq=False)
class BothSeen:
    """One part of a machine that both devices saw at the same points; axis positions while it was cut and probed."""

    serial: str
    part_type: str
    points: tuple[str, ...]
    seen: Inspections
    cutting: State
    probing: State
    compensated: bool
    new_frame: bool = False

    def components(self, model: MachineModel) -> tuple[Components, FrameDiscrepancy | None]:
        """Returns the errors taken apart at each point, the frames' discrepancy out first where taken anew."""
        found = error_components(model, self.seen, self.cutting, self.probing, compensated=self.compensated)
        if not self.new_frame:
            return found, None
        frame = fit_frame_discrepancy(self.seen, found.error_proc_resid)
        seen = without_discrepancy(self.seen, frame)
        return error_components(model, seen, self.cutting, self.probing, compensated=self.compensated), frame

    def left_mm(self, model: MachineModel) -> Array:
        """Returns the model's residuals along the normals, (n,): positive where more is left on than it predicts."""
        found = error_components(model, self.seen, self.cutting, self.probing, compensated=self.compensated)
        left: Array = found.error_mtg + found.comp_mtg_cutting
        return left


def checked(
    model: MachineModel, parts: Sequence[BothSeen], accept: Collection[str] = ()
) -> tuple[list[BothSeen], list[Finding]]:
    """Returns the parts that can be used, and findings on the others.

    Raises DIA-PART for one whose inspections cannot be of one part, DIA-MOVED for one that was moved between them, each
    unless `accept` has the code: the part is then left out.
    """
    kept: list[BothSeen] = []
    findings: list[Finding] = []
    for part in parts:
        refusal = _other_part(model, part) or _moved(model, part)
        if refusal is None:
            kept.append(part)
            continue
        if refusal.code not in accept:
            raise refusal
        findings.append(Finding(Severity.WARNING, refusal.code, refusal.message, refusal.hint, values=refusal.values))
    return kept, findings


def residuals(
    model: MachineModel, parts: Sequence[BothSeen], element: Mapping[str, str], accept: Collection[str] = ()
) -> tuple[tuple[BothSeen, ...], Residuals, list[Finding]]:
    """Returns the parts that can be used, and the model's residuals on them, the parts numbered from 0 in their order.

    `element` names the signal of each axis' element. Raises DIA-NONE without parts, DIA-SIGNAL where a signal of the
    model or of an element is missing, unless `accept` has it: those parts are left out.
    """
    needed = dict.fromkeys((*model.needs(), *element.values()))
    kept, findings = _with_signals(parts, tuple(needed), accept)
    if not kept:
        raise Code.DIA_NONE.refusal(
            f"0 of {len(parts)} parts can be used to judge the model",
            hint="`trueloop machine decompose --serial` keeps both inspections of a part, with its temperatures",
        )
    common = set.intersection(*(set(part.probing.signals) for part in kept))
    count = [len(part.points) for part in kept]
    signals = {
        name: np.repeat([float(np.mean(part.probing.signals[name])) for part in kept], count) for name in sorted(common)
    }
    tools = [
        np.broadcast_to(np.asarray(p.probing.tool_mm, np.float64), (n, 3)) for p, n in zip(kept, count, strict=True)
    ]
    positions = np.concatenate([part.probing.positions for part in kept])
    found = Residuals(
        np.repeat(np.arange(len(kept)), count),
        np.concatenate([part.seen.normal for part in kept]),
        State(positions, 0.0, signals, np.concatenate(tools)),
        np.concatenate([part.left_mm(model) for part in kept]),
        dict(element),
    )
    return tuple(kept), found, findings


def element_signals(model: MachineModel, names: Mapping[str, str]) -> dict[str, str]:
    """Returns each axis' element's signal: as given, else that of most parts of its terms. Raises MCH-AXIS."""
    chain: Chain = model.machine.chain
    found: dict[str, str] = {}
    for axis in chain.axes:
        used = [
            part.signal for term in model.terms if term.name.axis == axis.name for part in term.parts if part.signal
        ]
        if used:
            found[axis.name] = max(dict.fromkeys(used), key=used.count)
    for name, signal in names.items():
        found[chain.axis(name).name] = signal
    return found


def _with_signals(
    parts: Sequence[BothSeen], needed: Sequence[str], accept: Collection[str]
) -> tuple[list[BothSeen], list[Finding]]:
    for signal in needed:
        without = [part.serial for part in parts if signal not in part.probing.signals]
        if not without:
            continue
        said = f"the signal {signal!r} was not kept of {len(without)} of {len(parts)} parts: {', '.join(without[:5])}"
        hint = f"`trueloop machine decompose --probing {shell_word(signal)}=VALUE --supersede` keeps it"
        values = {"signal": signal, "parts": without}
        if Code.DIA_SIGNAL not in accept:
            raise Code.DIA_SIGNAL.refusal(said, hint=hint, override="--accept DIA-SIGNAL", values=values)
        rest = [part for part in parts if part.serial not in without]
        kept, findings = _with_signals(rest, needed, accept)
        return kept, [Finding(Severity.WARNING, Code.DIA_SIGNAL, said, hint, values=values), *findings]
    return list(parts), []


def _other_part(model: MachineModel, part: BothSeen) -> TrueloopError | None:
    largest_mm = float(np.abs(part.left_mm(model)).max())
    if largest_mm <= OTHER_PART_MM:
        return None
    return Code.DIA_PART.refusal(
        f"part {part.serial!r}: both devices differ by up to {largest_mm * UM_PER_MM:.0f} µm; of one part "
        f"they differ by less than {OTHER_PART_MM * UM_PER_MM:.0f} µm",
        hint="is one of the inspections of another part, or in another frame? Decompose the right file, `--supersede`",
        override="--accept DIA-PART",
        values={"part": part.serial},
    )


def _moved(model: MachineModel, part: BothSeen) -> TrueloopError | None:
    """Returns the refusal where a large rigid motion explains the devices' differences, their frames not taken anew."""
    if part.new_frame or len(part.points) < 7:
        return None
    found = error_components(model, part.seen, part.cutting, part.probing, compensated=part.compensated)
    frame = fit_frame_discrepancy(part.seen, found.error_proc_resid)
    if frame.rms_before_mm < MOVED_MM or frame.rms_after_mm > frame.rms_before_mm / MOVED_SHARE:
        return None
    return Code.DIA_MOVED.refusal(
        f"part {part.serial!r}: both inspections differ by {frame.rms_before_mm * UM_PER_MM:.1f} µm, and by "
        f"{frame.rms_after_mm * UM_PER_MM:.1f} µm after a rigid motion: part or probe was moved between them",
        hint="if the part's frame was found anew, decompose it with `--new-frame --supersede`",
        override="--accept DIA-MOVED",
        values={"part": part.serial},
    )


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
    return MachineDiagnosis(
        parts=kept,
        seen=seen,
        verdict=verdict,
        frames=frames,
        own_way=own_way,
        findings=(*odd, *missing, *moved, *verdict.notes),
    )


def _frames(parts: Sequence[BothSeen], residuals: Residuals, u_mm: float) -> Frames | None:
    """Returns the differences of CMM and machine as motions of the part frames [6876 §3.1]."""
    if len(parts) < LEAST_PARTS:
        return None
    nominal_mm = np.concatenate([part.seen.nominal_mm for part in parts])
    names = [part.serial for part in parts]
    return reconcile_frames(residuals.part, nominal_mm, residuals.normal, residuals.residual_mm, u_mm, names)


def states_of(
    model: MachineModel, inspections: Inspections, zero: Vector, tool: Array | Vector, signals: Signals
) -> State:
    """Axis positions that bring the tool point to each gauging point: part + zero − tool, one tool or (n, 3)."""
    axes = inspections.nominal_mm + np.array(zero) - np.array(tool)
    chain = model.machine.chain
    given = {name: axes[:, k] for k, name in enumerate("XYZ") if name in chain.order}
    return State(chain.positions(given), 0.0, signals, tool)


def decompose_part(
    model: MachineModel, part: BothSeen, extrapolate: Collection[str] = ()
) -> tuple[Components, FrameDiscrepancy | None]:
    """Components at each gauging point; with `new_frame` after the part coordinate system discrepancy is taken out.

    Raises MCH-TRAVEL and MCH-RANGE for states at which the model is not known to hold; `extrapolate` names what may
    leave the range of the data.
    """
    check_state(model, part.cutting, extrapolate)
    check_state(model, part.probing, extrapolate)
    return part.components(model)
