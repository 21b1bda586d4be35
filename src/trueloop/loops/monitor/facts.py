"""What is known of each part of a series beside its sizes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime

from trueloop.domain.life import Cut, EdgeEvent


@dataclass(frozen=True)
class PartFacts:
    """One part, in cutting order. `events`: of its edge since the part before. `proposals`: accepted since then.

    `minutes` is what its edge had cut before it; None: not known. `temperatures` in °C by sensor. `failed`: that the
    last check of the device by which it was measured failed, in words; empty: it did not, or there was none.
    """

    serial: str
    at: datetime | None = None
    cut: Cut | None = None
    events: tuple[EdgeEvent, ...] = ()
    proposals: tuple[str, ...] = ()
    minutes: float | None = None
    temperatures: Mapping[str, float] = field(default_factory=dict)
    device: str = ""
    failed: str = ""
