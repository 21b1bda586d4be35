"""Every way in which memory refuses to predict."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tests.unit.memory.edge.parts import ANGLES, series
from trueloop.errors import Code
from trueloop.memory.edge.expect import expect
from trueloop.memory.edge.options import MemoryOptions
from trueloop.memory.made_part import ArcErrors

HISTORY = series(1)
UNTOUCHED = replace(series(2)[1], semifinish=ArcErrors.none(), finish=None, correction_mm=None)


def _asked(*, angle_deg: float = 45.0, options: MemoryOptions | None = None, **changed: str) -> object:
    today = replace(UNTOUCHED, **changed)  # type: ignore[arg-type]
    return expect(HISTORY, today, np.append(ANGLES, np.radians(angle_deg)), options or MemoryOptions())


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.MEM_UNSEEN: lambda: _asked(angle_deg=101.0),
    Code.MEM_SETTING: lambda: _asked(setting="2"),
    Code.MEM_TYPE: lambda: _asked(part_type="knob"),
    Code.MEM_GAIN: lambda: expect(series(3, gain=-1.0), UNTOUCHED, ANGLES, MemoryOptions()),
    Code.MEM_PART: lambda: _asked(options=MemoryOptions("frozen", last_part="17")),
}
