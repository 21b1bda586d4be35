"""The options of charting a series."""

from dataclasses import dataclass
from typing import Final, Literal

BASELINE: Final = 20
"""The number of parts of the baseline where none is stated: its standard deviation is then known to 20 %."""


@dataclass(frozen=True)
class ChartOptions:
    """`rules`: numbers of Nelson's tests. `baseline`: from how many parts at the beginning of each segment limits come,
    or from which to which serial number of the series. `anew`: a tool set anew begins a new segment.

    `what`: errors of the parts as inspected, or residuals after correction: what memory did not expect of a part, in
    standard deviations of its expectation.
    """

    rules: tuple[int, ...] = (1,)
    baseline: int | tuple[str, str] = BASELINE
    anew: bool = False
    what: Literal["value", "residual"] = "value"
