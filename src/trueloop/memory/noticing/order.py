"""Parts whose order is in doubt."""

import math
from collections.abc import Sequence

from trueloop.arrays import Array


def doubtful_order(inspected_as: Array | Sequence[float]) -> tuple[int, ...]:
    """Of parts in the order in which they are said to have been cut, the indices of those that were inspected before
    one that was cut earlier, or at the same number: wear, drift and history of such a part are uncertain.

    `inspected_as` is the number or time of each inspection; NaN where there is none.

    >>> doubtful_order([5, 6, 9, 8])
    (3,)
    """
    found, latest = [], float("-inf")
    for index, at in enumerate(inspected_as):
        if at <= latest:
            found.append(index)
        latest = latest if math.isnan(at) else max(latest, at)
    return tuple(found)
