"""One part inspected on its machine and on a measuring machine, and how the machine stood then."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from trueloop.domain.inspection import Vector
from trueloop.domain.life import Identity
from trueloop.domain.machine import Machine
from trueloop.domain.part import Part


@dataclass(frozen=True)
class MachineStood:
    """How a machine stood while a part was cut or probed.

    `work_zero_mm` are machine coordinates of the part's zero. `tools_mm` lead from the frame of the last axis that
    carries the tool to its point (or to the stylus): one for all gauging points, or one a point. `signals` by name, in
    the unit that the machine's model has them in; a signal that was not recorded is missing.
    """

    work_zero_mm: Vector
    tools_mm: tuple[Vector, ...]
    signals: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class BothInspections:
    """That two inspections, named by their identity, are of one part at the same gauging points in the same order.

    Both hold CMM points: `on_machine` what the control reported at contact, before any adjustment, `on_cmm` what the
    measuring machine found. `model_sha256` is that of the model file whose COMP_MTG was in force while the part was cut
    where `compensated`, else of the model that it was taken apart by. `comp_proc_mm` is the process correction that was
    applied, along the normals; empty: none. `new_frame`: the part's frame was found anew on the measuring machine.
    Standard uncertainties are of one point.
    """

    part: Part
    machine: Machine
    on_machine: Identity
    on_cmm: Identity
    cutting: MachineStood
    probing: MachineStood
    model_sha256: str
    compensated: bool
    touch_u_mm: float = 0.0
    cmm_u_mm: float = 0.0
    comp_proc_mm: tuple[float, ...] = ()
    new_frame: bool = False
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns the identities of both inspections."""
        return *self.on_machine, *self.on_cmm
