"""Every way in which memory refuses to predict."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tests.unit.memory.edge.parts import ANGLES, series
from trueloop.domain.life import Stage
from trueloop.errors import Code
from trueloop.jobs.store.keep_facts import alarms_of
from trueloop.memory.edge.learnt import MemoryOptions
from trueloop.memory.edge.predict import expect
from trueloop.memory.made_part import CutErrors
from trueloop.memory.noticing import notice_part

HISTORY = series(1)
UNTOUCHED = replace(series(2)[1], semifinish=CutErrors.none(), finish=None, correction_mm=None)


def _asked(*, angle_deg: float = 45.0, options: MemoryOptions | None = None, **changed: str) -> object:
    today = replace(UNTOUCHED, **changed)  # type: ignore[arg-type]
    asked = CutErrors.asked(np.append(ANGLES, np.radians(angle_deg)), "dome")
    return expect(HISTORY, today, asked, options or MemoryOptions())


def _not_run() -> object:
    """A part whose correction was not run, by the arithmetic of the model: F + C is left instead of F."""
    *before, last = series(4)
    assert last.finish is not None and last.correction_mm is not None
    finish = replace(last.finish, error_mm=last.finish.error_mm + last.correction_mm)
    seen = notice_part(before, replace(last, finish=finish))[Stage.FINISH]
    return list(alarms_of(last.serial, seen, learns=False))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.MEM_UNSEEN: lambda: _asked(angle_deg=101.0),
    Code.MEM_SETTING: lambda: _asked(setting="2"),
    Code.MEM_TYPE: lambda: _asked(part_type="knob"),
    Code.MEM_GAIN: lambda: expect(series(3, gain=-1.0), UNTOUCHED, CutErrors.asked(ANGLES, "dome"), MemoryOptions()),
    Code.MEM_ALARM: _not_run,
    Code.MEM_PART: lambda: _asked(options=MemoryOptions("frozen", last_part="17")),
}
