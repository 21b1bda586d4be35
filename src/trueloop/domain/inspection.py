"""An inspection: what was measured on one part, by which device, in which frame, when and how warm it was."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from functools import lru_cache
from typing import Literal, TypeAlias, TypeVar, cast

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.life import Identity
from trueloop.domain.part import Part
from trueloop.domain.tool import Machine
from trueloop.geometry.feature import Point

T = TypeVar("T")
Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Touch:
    """One gauging point as it was reported: nominal (x, z) in mm with x a radius, and a measured point or an error.

    `error_mm` is along the outward normal, positive where material was left on. `line` is that of the file.
    """

    point: str
    nominal_mm: Point
    feature: str | None = None
    measured_mm: Point | None = None
    error_mm: float | None = None
    line: int | None = None


@dataclass(frozen=True, slots=True)
class Reading:
    """One characteristic of one part as a gauge, a measuring machine or a control reported it.

    `actual`, `nominal`, `standard_u` and the limits are in mm, of angles in degrees. A diameter is a diameter: it
    deviates by twice the radial error. Limits are absolute. `feature` is the feature's name in the file, which need
    not be that of the job; `other` names the one from which a length counts, empty: the part's zero; `axis` is that of
    a coordinate. `place_mm` is where it was read, in the part's frame: of a turned part z, or x as a radius and z; of
    others x, y, z. `repeat` counts readings of one characteristic on one part, from 1: they are kept apart, for their
    spread is the gauge's repeatability. None and empty: not stated.
    """

    characteristic: str
    quantity: Quantity
    actual: float
    nominal: float | None = None
    lower_limit: float | None = None
    upper_limit: float | None = None
    feature: str = ""
    other: str = ""
    axis: Literal["", "x", "y", "z"] = ""
    place_mm: tuple[float, ...] = ()
    repeat: int = 1
    standard_u: float | None = None
    measured_at: datetime | None = None
    temperature_c: float | None = None
    line: int | None = None
    side: Literal["", "inner", "outer"] = ""

    def size(self, nominal: float) -> Characteristic:
        """Returns the size with that nominal value that the reading is of, with its limits."""
        limits = self.lower_limit, self.upper_limit
        return Characteristic(self.characteristic, self.quantity, self.feature, nominal, *limits, other=self.other)


@dataclass(frozen=True, slots=True)
class CmmPoint:
    """One point of a coordinate measuring machine, mm, in the frame of the inspection; normals leave the material."""

    measured_mm: Vector
    nominal_mm: Vector | None = None
    outward_normal: Vector | None = None
    name: str = ""


Values: TypeAlias = tuple[Touch | Reading | CmmPoint, ...]


@dataclass(frozen=True)
class Inspection:
    """Values measured on one part in one run of a device.

    `sha256` is that of the file it was read from: a file that holds several parts or runs gives several inspections.
    `count` says how many `values` were measured: they are left out where the file holds too many to repeat, and then
    `values` is empty. `ball_radius_mm`: where it is above 0, measured points are centres of that ball; else they are
    points of the surface. `frame`: "part" where positions are counted from the part's datums, "machine" where from the
    machine tool's zero, "device" where from the measuring device's, so that they have to be aligned. `z_reference`
    names the touch from which the part's z was taken. `temperatures` by the name of the sensor, °C, with further
    signals in the unit of their data. `devices` by characteristic, where several devices measured, of which `device` is
    the list; a file read before it was kept is equal. Empty text and None: not stated.
    """

    part: Part
    measured: Literal["touches", "readings", "CMM points", "readings and CMM points"]
    sha256: str
    count: int
    values: Values = ()
    device: str = ""
    operator: str = ""
    frame: Literal["part", "machine", "device"] = "part"
    measured_at: datetime | None = None
    ball_radius_mm: float = 0.0
    z_reference: str | None = None
    temperatures: Mapping[str, float] = field(default_factory=dict)
    devices: Mapping[str, str] = field(default_factory=dict, compare=False)
    schema: Literal[1] = field(default=1, kw_only=True)

    def device_of(self, characteristic: str) -> str:
        """Returns the device that measured a characteristic, several with commas; empty: not stated."""
        return self.devices.get(characteristic, self.device)

    @property
    def touches(self) -> tuple[Touch, ...]:
        """Returns the values that are touches."""
        return _of(Touch, self.values)

    @property
    def readings(self) -> tuple[Reading, ...]:
        """Returns the values that are readings."""
        return _of(Reading, self.values)

    @property
    def points(self) -> tuple[CmmPoint, ...]:
        """Returns the values that are points of a measuring machine."""
        return _of(CmmPoint, self.values)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the hash of its file, with part and time, as a file may hold several: read twice, it is the same."""
        return self.sha256, *self.part.identity, "" if self.measured_at is None else self.measured_at.isoformat()


def _of(kind: type[T], values: Values) -> tuple[T, ...]:
    """The values of one type; where there may be millions, mostly all of them."""
    kinds = set(map(type, values))
    if kinds <= {kind}:
        return cast(tuple[T, ...], values)
    return tuple(value for value in values if isinstance(value, kind)) if kind in kinds else ()


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


@dataclass(frozen=True)
class StandardPart:
    """A calibrated part. `values` hold the calibrated sizes, each with its `standard_u`; `by` whom and `at` what time.

    Inspections of that part show the probe and the machine, never a cut. `temperature_c` is that of the calibration.
    """

    part: Part
    values: tuple[Reading, ...]
    at: datetime | None = None
    by: str = ""
    temperature_c: float = 20.0
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns part and time: it may be calibrated again."""
        return *self.part.identity, "" if self.at is None else self.at.isoformat()


def index_of_name(names: tuple[str, ...], name: str) -> int | None:
    """Returns the index of a name among others, else of the only one that differs in case, blanks and signs alone."""
    return names.index(name) if name in names else _by_letters(names).get(_letters(name))


@lru_cache(maxsize=16)
def _by_letters(names: tuple[str, ...]) -> Mapping[str, int]:
    """Returns the index by the letters of the names, of those that no other has: a file may hold a million points."""
    letters = [_letters(name) for name in names]
    return {one: k for k, one in enumerate(letters) if one and letters.count(one) == 1}


def _letters(name: str) -> str:
    return "".join(filter(str.isalnum, name.casefold()))
