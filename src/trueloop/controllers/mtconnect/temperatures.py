"""Temperatures that an agent held, as a log: a row at each moment at which one changed and all are known."""

import math
import re
from collections.abc import Sequence

from trueloop.controllers.linuxcnc.realtime.signals.time_stamps import unix_s
from trueloop.controllers.mtconnect.agent import Seen
from trueloop.errors import Code, TrueloopError


def temperature_log(url: str, seen: Sequence[Seen]) -> str:
    """CSV: `time_s` since 1970, NAME_degC. A temperature holds until another is said, or UNAVAILABLE.

    Raises MTC-AGENT where never all were known.
    """
    named = {one.item.id: _column(one) for one in seen if one.item.type.upper() == "TEMPERATURE"}
    rows: dict[float, list[float]] = {}
    latest: dict[str, float] = {}
    for time_s, one in sorted(
        ((_time_s(url, one), one) for one in seen if one.item.id in named), key=lambda row: row[0]
    ):
        latest[one.item.id] = _celsius(one.value)
        values = [latest.get(item, math.nan) for item in named]
        if all(map(math.isfinite, values)):
            rows[time_s] = values
        else:
            rows.pop(time_s, None)
    if not rows:
        raise _refused(url, f"{len(named)} temperatures, and at no moment all of them were known")
    head = ",".join(["time_s", *(f"{name}_degC" for name in named.values())])
    return "\n".join([head, *(f"{t:.6f},{','.join(f'{v:g}' for v in row)}" for t, row in rows.items()), ""])


def _column(one: Seen) -> str:
    return re.sub(r"\W", "_", one.item.name or one.item.id)


def _celsius(value: str) -> float:
    try:
        return float(value)
    except ValueError:
        return math.nan


def _time_s(url: str, one: Seen) -> float:
    try:
        return unix_s(one.stamp)
    except ValueError as error:
        raise _refused(url, f"{one.item.id!r} at {one.stamp[:40]!r}: {error}") from error


def _refused(url: str, why: str) -> TrueloopError:
    return TrueloopError(
        Code.MTC_AGENT, f"{url}: {why}", hint="read for longer, or see which items are UNAVAILABLE", values={"url": url}
    )
