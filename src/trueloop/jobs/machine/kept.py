"""Both inspections of one part, on the machine and on a measuring machine, kept in a store."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.components import Inspections
from trueloop.domain.inspection import BothInspections, CmmPoint, Inspection, MachineStood, Vector
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.domain.tool import Machine
from trueloop.jobs.store.keep_facts import KeptFacts, keep_facts
from trueloop.jobs.store.of_this_part import require_file_of_part
from trueloop.jobs.store.opened import Keeping, store_of
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import means


@dataclass(frozen=True)
class Decomposed:
    """One part as it was taken apart: the file, its points, and how the machine stood while it was cut and probed.

    `zero_mm` are machine coordinates of the part's zero. `model_sha256` is that of the model's file.
    """

    path: Path
    points: Sequence[str]
    seen: Inspections
    model: MachineModel
    model_sha256: str
    zero_mm: Vector
    cutting: State
    probing: State
    compensated: bool
    new_frame: bool


def keep_both(of: Decomposed, part_type: str, serial: str, keeping: Keeping) -> KeptFacts:
    """Keeps the part with both devices' inspections and how its machine stood.

    Raises STO-OTHER-PART for a file that is kept as another part's, and what keeping refuses.
    """
    store = store_of(of.path.parent, keeping.db, None, "made")
    assert store is not None  # made where there is none
    part = Part(PartType(part_type), serial)
    on_machine, on_cmm = _inspections(of, part)
    for one in (on_machine, on_cmm):
        require_file_of_part(store, one)
    return keep_facts(store, (part, on_machine, on_cmm, _both(of, on_machine, on_cmm)), supersede=keeping.supersede)


def _inspections(of: Decomposed, part: Part) -> Iterator[Inspection]:
    """One inspection a device. What tells them apart is the hash: of the file, and of which of its columns it is."""
    sha256 = sha256_of(of.path.read_bytes())
    for device, measured_mm in (("machine's probe", of.seen.controller_mm), ("measuring machine", of.seen.cmm_mm)):
        values = tuple(_points(of.points, of.seen, measured_mm))
        own = sha256_of(f"{sha256} {device}".encode())
        yield Inspection(part=part, measured="CMM points", sha256=own, count=len(values), values=values, device=device)


def _both(of: Decomposed, on_machine: Inspection, on_cmm: Inspection) -> BothInspections:
    seen, named = of.seen, of.model.machine
    comp_proc_mm = np.atleast_1d(np.asarray(seen.comp_proc_mm, dtype=np.float64))
    return BothInspections(
        part=on_machine.part,
        machine=Machine(named.name, named.serial),
        on_machine=on_machine.identity,
        on_cmm=on_cmm.identity,
        cutting=_stood(of.zero_mm, of.cutting),
        probing=_stood(of.zero_mm, of.probing),
        model_sha256=of.model_sha256,
        compensated=of.compensated,
        touch_u_mm=seen.touch_u_mm,
        cmm_u_mm=seen.cmm_u_mm,
        comp_proc_mm=tuple(comp_proc_mm.tolist()) if comp_proc_mm.any() else (),
        new_frame=of.new_frame,
    )


def _stood(zero_mm: Vector, state: State) -> MachineStood:
    tools = np.atleast_2d(np.asarray(state.tool_mm, dtype=np.float64))
    same = len(tools) > 0 and bool(np.all(tools == tools[0]))
    return MachineStood(zero_mm, tuple(_vector(one) for one in (tools[:1] if same else tools)), means(state.signals))


def _points(points: Sequence[str], inspections: Inspections, measured_mm: Array) -> Iterator[CmmPoint]:
    for k, name in enumerate(points):
        measured, nominal, normal = (_vector(of[k]) for of in (measured_mm, inspections.nominal_mm, inspections.normal))
        yield CmmPoint(measured, nominal, normal, name)


def _vector(of: Array) -> Vector:
    x, y, z = of.tolist()
    return x, y, z
