"""Parts that were inspected on their machine and on a measuring machine, from a store."""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trueloop.diagnosis.components import Inspections
from trueloop.domain.inspection import BothInspections, CmmPoint, Inspection, MachineStood
from trueloop.domain.life import Identity
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.formats.tables.model_file import read_model
from trueloop.jobs.diagnose.records import quarantined_parts
from trueloop.loops.diagnosis.left_on_parts import BothSeen, states_of
from trueloop.machine.model.model import MachineModel, State
from trueloop.storage.store import Store, find
from trueloop.wording import did_you_mean

DECOMPOSE = "`trueloop machine decompose --serial` keeps both inspections of a part"


@dataclass(frozen=True, eq=False)
class GivenModel:
    """A model with the file and its hash."""

    path: Path
    model: MachineModel
    sha256: str


def given_model(path: Path) -> GivenModel:
    """Reads a model file. Raises MCH-FILE."""
    return GivenModel(path, read_model(path, offered=True), sha256_of(path.read_bytes()))


def both_of_machine(
    store: Store, model: GivenModel, part_types: Collection[str] = (), accept: Collection[str] = ()
) -> tuple[list[BothSeen], list[Finding]]:
    """Returns all parts of the model's machine, in the order in which they were kept; without those in quarantine.

    Raises DIA-NONE where there is none, DIA-PART for a part of a machine of that name with another serial number, which
    `accept` leaves out. A note DIA-MODEL names which parts were cut under another model.
    """
    machine = model.model.machine
    kept = [one.value for one in find(store, BothInspections, machine=machine.name)]
    of_type = [pair for pair in kept if not part_types or pair.part.part_type.name in part_types]
    if not of_type:
        stored = [one.value for one in find(store, BothInspections)]
        machines = sorted({pair.machine.name for pair in stored})
        types = sorted({pair.part.part_type.name for pair in stored if pair.machine.name == machine.name})
        asked, known = (machine.name, machines) if machine.name not in machines else (next(iter(part_types), ""), types)
        of = f" of part type {asked!r}" if machine.name in machines else ""
        raise Code.DIA_NONE.refusal(
            f"the store holds 0 parts{of} that machine {machine.name!r} and a measuring machine inspected",
            hint=did_you_mean(asked, known) or f"known are {', '.join(known) or 'none'}; {DECOMPOSE}",
        )
    findings: list[Finding] = []
    own = [pair for pair in of_type if not machine.serial or pair.machine.serial in ("", machine.serial)]
    for pair in of_type:
        if pair not in own:
            findings.append(_accepted(_other_machine(pair, machine.serial), accept))
    out = quarantined_parts(store)
    serials = [pair.part.serial for pair in own if pair.part.identity in out]
    if serials:
        message = f"{len(serials)} parts are in quarantine and left out: {', '.join(serials[:5])}"
        hint = "`trueloop db show` says why"
        findings.append(
            Finding(Severity.NOTE, Code.DIA_FEW, message, hint, values={"count": len(own) - len(serials), "needed": 2})
        )
    own = [pair for pair in own if pair.part.identity not in out]
    findings += cut_under_others(own, model.sha256)
    inspections = {one.value.identity: one.value for one in find(store, Inspection)} if own else {}
    return [both_seen(pair, inspections, model.model) for pair in own], findings


def both_seen(pair: BothInspections, inspections: Mapping[Identity, Inspection], model: MachineModel) -> BothSeen:
    """Converts both inspections for a diagnosis. Raises DIA-PART where they are not of the same points of that part."""
    on_machine, on_cmm = (inspections.get(identity) for identity in (pair.on_machine, pair.on_cmm))
    if on_machine is None or on_cmm is None:
        raise _not_alike(pair, "one of its two inspections is not in the store, or was superseded")
    if {on_machine.part.identity, on_cmm.part.identity} != {pair.part.identity}:
        raise _not_alike(pair, "its two inspections are kept as of other parts")
    nominal, normal, controller = _arrays(on_machine)
    other_nominal, _, cmm = _arrays(on_cmm)
    if nominal.shape != other_nominal.shape or not np.allclose(nominal, other_nominal, atol=1e-6):
        raise _not_alike(pair, f"{len(nominal)} and {len(other_nominal)} points are not the same gauging points")
    comp_proc_mm = np.array(pair.comp_proc_mm) if pair.comp_proc_mm else 0.0
    seen = Inspections(
        nominal_mm=nominal,
        normal=normal,
        controller_mm=controller,
        cmm_mm=cmm,
        touch_u_mm=pair.touch_u_mm,
        cmm_u_mm=pair.cmm_u_mm,
        comp_proc_mm=comp_proc_mm,
    )
    names = tuple(point.name for point in on_machine.points)
    cutting, probing = (_state(model, seen, stood) for stood in (pair.cutting, pair.probing))
    kind = pair.part.part_type.name
    return BothSeen(
        serial=pair.part.serial,
        part_type=kind,
        points=names,
        seen=seen,
        cutting=cutting,
        probing=probing,
        compensated=pair.compensated,
        new_frame=pair.new_frame,
    )


def _state(model: MachineModel, inspections: Inspections, stood: MachineStood) -> State:
    tools = stood.tools_mm[0] if len(stood.tools_mm) == 1 else np.array(stood.tools_mm)
    return states_of(model, inspections, stood.work_zero_mm, tools, stood.signals)


def _arrays(of: Inspection) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    points: tuple[CmmPoint, ...] = of.points
    columns = ([p.nominal_mm for p in points], [p.outward_normal for p in points], [p.measured_mm for p in points])
    nominal, normal, measured = (np.array(rows, dtype=np.float64).reshape(-1, 3) for rows in columns)
    return nominal, normal, measured


def _accepted(refusal: TrueloopError, accept: Collection[str]) -> Finding:
    if refusal.code not in accept:
        raise refusal
    return Finding(Severity.WARNING, refusal.code, refusal.message, refusal.hint, values=refusal.values)


def _other_machine(pair: BothInspections, serial: str) -> TrueloopError:
    return Code.DIA_PART.refusal(
        f"part {pair.part.serial!r} was cut on {pair.machine.name!r} with serial number {pair.machine.serial!r}, the "
        f"model is of {serial!r}",
        hint="every machine errs in its own way: name the model of that machine",
        override="--accept DIA-PART",
        values={"part": pair.part.serial},
    )


def _not_alike(pair: BothInspections, why: str) -> TrueloopError:
    return Code.DIA_PART.refusal(
        f"part {pair.part.serial!r}: {why}",
        hint="decompose it again: `trueloop machine decompose --serial … --supersede`",
        values={"part": pair.part.serial},
    )


def cut_under_others(own: Collection[BothInspections], sha256: str) -> Iterator[Finding]:
    """Yields DIA-MODEL as a note: parts that were cut under another model than the one of that hash."""
    others = [pair for pair in own if pair.compensated and pair.model_sha256 != sha256]
    if others:
        serials = [pair.part.serial for pair in others]
        yield Finding(
            Severity.NOTE,
            Code.DIA_MODEL,
            f"{len(others)} of {len(own)} parts were cut under another model: {', '.join(serials[:5])}",
            "what this model would have left is worked out from what the control reported; it holds if the control did "
            "not correct its own readings",
            values={"part": serials[0]},
        )
