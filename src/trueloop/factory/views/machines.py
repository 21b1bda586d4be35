"""One machine with all that is known of it."""

from dataclasses import dataclass
from datetime import datetime

from trueloop.factory.views.orders import TransferView
from trueloop.factory.views.today import MachineNow


@dataclass(frozen=True)
class CalibrationView:
    """A calibration of a machine's probe: `values` are what was found, as it was told."""

    at: datetime
    who: str
    values: dict[str, str]


@dataclass(frozen=True)
class TemperatureView:
    """What a sensor said, oldest first, °C; the latest hours, no more than a picture shows."""

    signal: str
    at: tuple[datetime, ...]
    celsius: tuple[float, ...]
    stale: bool


@dataclass(frozen=True)
class MachineView:
    """One machine: what it does, its links, the model in force, its last calibrations, temperatures and transfers.

    `part_id` is the part that it cuts; None: none that an order made.
    """

    now: MachineNow
    part_id: int | None
    model_version: str
    keys: int
    calibrations: tuple[CalibrationView, ...]
    temperatures: tuple[TemperatureView, ...]
    transfers: tuple[TransferView, ...]
