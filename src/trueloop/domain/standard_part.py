"""Standard parts: calibrated, so that a probe that finds them otherwise is wrong itself [4773 §4.2]."""

from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal

from trueloop.domain.inspection import Reading
from trueloop.domain.life import Identity
from trueloop.domain.part import Part


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
