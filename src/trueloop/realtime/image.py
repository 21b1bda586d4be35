"""The image that the component in the servo thread loads: a model linear in its signals, a table by line, and limits.

Machine coordinates in mm, X of a lathe as a radius. The model gives E = actual − commanded; what is added is −E and the
table's rows. `formats/realtime/image_file.py` writes and reads the file.
"""

from dataclasses import dataclass
from typing import Final

from trueloop.arrays import Array, by_content
from trueloop.machine.model.chain import ZERO, Vector

SIGNALS = 16
"""Signals at most."""

TRAVEL_TOLERANCE_MM: Final = 1e-4
"""Distance outside the travel without a fault; `crates/rtec/src/corrector/travel.rs` states why."""


@dataclass(frozen=True)
class Identity:
    """Whose image it is. Hashes are hex digits; "" where there is no model, no table, no record."""

    machine: str
    serial: str
    model_sha256: str = ""
    program: str = ""
    program_sha256: str = ""
    record: str = ""


@dataclass(frozen=True)
class Signal:
    """One signal of the model: the value that the bank counts from, the range in which it holds, its largest step."""

    name: str
    unit: str
    reference: float
    low: float
    high: float
    most_step: float


@by_content
@dataclass(frozen=True)
class Body:
    """Six errors that act on one frame, as `machine.model.compiled.Body`, at the signals' reference values.

    `powers` (1 or 3, segments, powers, 6). `per_unit` holds what one unit of a signal adds, by the signal's place in
    the bank, in the same shape; signals that do not act on this frame are left out. `arm_mm` is that of a tool of no
    length: the tool's vector is added to it.
    """

    axis: int
    breaks: Array
    powers: Array
    per_unit: tuple[tuple[int, Array], ...]
    arm_mm: Array
    carries: Array


@by_content
@dataclass(frozen=True)
class Bank:
    """A machine model for all signals: E is linear in each. `slope` (1 + signals, 3, 3): at the references, per unit.

    `tool_mm` is the tool point from the frame of the last axis while the control's tool offset is zero; an offset in
    force is subtracted from it.
    """

    signals: tuple[Signal, ...]
    bodies: tuple[Body, ...]
    slope: Array
    tool_mm: Vector = ZERO


@by_content
@dataclass(frozen=True)
class Block:
    """The correction along one block of a program, whose first line is 1.

    `rows` (n, 4): x as a radius, z where the axes are commanded in machine coordinates, and what is added there; mm, in
    order of cutting.
    """

    line: int
    rows: Array


@dataclass(frozen=True)
class RealTimeLimits:
    """Limits that the component applies to every correction, whatever its pins are set to.

    `limit_mm`: the largest correction of an axis. `gate_mm`: how far off its path a row still holds. `travel_mm`:
    lowest and highest position of X, Y, Z that a drive may be sent to.
    """

    travel_mm: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    limit_mm: float = 0.150
    gate_mm: float = 0.1


@by_content
@dataclass(frozen=True)
class Image:
    """All that the component needs; `bank` None: a table alone; no blocks: a model alone."""

    identity: Identity
    limits: RealTimeLimits
    bank: Bank | None = None
    blocks: tuple[Block, ...] = ()
