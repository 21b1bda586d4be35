"""The report's own way to name an axis error: one correlation after another [4773 §3.3, Table 1].

Each row of Table 1 is a product of what it is proportional to: temperature of the element, position, arm of the tool.
The row whose product correlates best with the residuals of its component, the mean of every part taken out, is named.
"""

from collections.abc import Iterator, Mapping

import numpy as np

from trueloop.arrays import Array
from trueloop.simulator.diagnosed.seen import MachineSeen

NEEDED = 0.2
"""Below this correlation nothing is named."""


def named(seen: MachineSeen) -> str:
    """The one axis error that correlates best, "" if none does."""
    best, found = NEEDED, ""
    for component, axis in ((0, 0), (1, 2)):
        rows = seen.normal[:, axis] > 0.7
        for name, product in _table(seen, component).items():
            size = abs(_correlation(seen.residual_mm[rows], product[rows]))
            if size > best:
                best, found = size, name
    return found


def _table(seen: MachineSeen, component: int) -> Mapping[str, Array]:
    """Products of Table 1 for e_r or e_z by the axis error that they stand for."""
    return dict(_rows(seen, component))


def _rows(seen: MachineSeen, component: int) -> Iterator[tuple[str, Array]]:
    work = seen.positions + seen.tool_mm[:, [0, 2]]
    spindle, carriage, slide = (seen.signals[name] for name in ("T spindle", "T carriage", "T cross slide"))
    spindle, carriage, slide = (values - values.mean() for values in (spindle, carriage, slide))
    if component == 0:
        yield "EX0C", spindle
        yield "EXZ", carriage * work[:, 1]
        yield "EB0C", spindle * work[:, 1]
        yield "EBZ", carriage * seen.tool_mm[:, 2]
        yield "EXX", slide * work[:, 0]
        yield "EBX", slide * seen.tool_mm[:, 2]
    else:
        yield "EZ0C", spindle
        yield "EB0C", spindle * work[:, 0]
        yield "EBX", slide * seen.tool_mm[:, 0]
        yield "EZX", slide * work[:, 0]
        yield "EZZ", carriage * work[:, 1]
        yield "EBZ", carriage * (seen.tool_mm[:, 0] + seen.positions[:, 0])


def _correlation(values: Array, product: Array) -> float:
    if len(values) < 3 or np.ptp(product) == 0.0:
        return 0.0
    return float(np.corrcoef(values, product)[0, 1])
