"""Every way in which the quality monitor refuses to chart, or to say how capable a process is."""

from collections.abc import Callable

import numpy as np

from tests.support.series import followed
from trueloop.errors import Code
from trueloop.loops.monitor.chart import ChartOptions, chart_of
from trueloop.loops.monitor.known import PartFacts
from trueloop.monitoring.capability import capability

ERRORS_UM = (3.0, 5.0, 4.0, 6.0, 5.0, 4.0, 3.0, 5.0, 6.0)


def _charted(*errors_um: float, baseline: int | tuple[str, str] = 20) -> object:
    tracked = followed(*errors_um)
    return chart_of(tracked, [PartFacts(one.made.serial) for one in tracked.parts], ChartOptions(baseline=baseline))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.MON_NONE: lambda: _charted(*ERRORS_UM, baseline=("1", "99")),
    Code.MON_FEW: lambda: _charted(*ERRORS_UM[:5]),
    Code.MON_LIMITS: lambda: capability(np.array(ERRORS_UM), 10.0, -10.0),
}
