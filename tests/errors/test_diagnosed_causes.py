"""What the diagnosis of a series says of its own records."""

from collections.abc import Callable
from datetime import datetime

from trueloop.diagnosis.causes.cause import SeenPart, SeenSeries
from trueloop.diagnosis.causes.judge import noticed
from trueloop.errors import Code

EARLIER, LATER = datetime(2026, 3, 2, 6), datetime(2026, 3, 2, 7)


def _arrived_twice() -> object:
    return noticed(SeenSeries({}, ()), 2.0, 0.99)[0]


def _cut_before_the_one_before() -> object:
    return noticed(SeenSeries({}, (SeenPart("A", 0, {}, at=LATER), SeenPart("B", 1, {}, at=EARLIER))), 1.0, 1.0)[0]


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.DIA_GAIN: _arrived_twice,
    Code.DIA_CLOCK: _cut_before_the_one_before,
}
