"""When a value was read, by the time stamp that comes with it."""

import math
from datetime import UTC, datetime


def unix_s(stamp: object) -> float:
    """Converts an ISO 8601 text (without a zone: UTC) or s or ms since 1970 to s since 1970.

    Raises `ValueError` for anything else.
    """
    if isinstance(stamp, str):
        moment = datetime.fromisoformat(stamp.strip())
        return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()
    if isinstance(stamp, bool) or not isinstance(stamp, (int, float)) or not math.isfinite(stamp):
        raise ValueError(f"{str(stamp)[:40]!r} is no time")
    return stamp / 1000 if stamp > 1e11 else float(stamp)  # 1e11 s is in the year 5138


def reported_s(stamp_s: float, source_now_s: float, asked_s: float, skew_s: float) -> float:
    """Returns when a value was read, on the clock that read `asked_s` when the source's read `source_now_s`.

    Raises `ValueError` for a stamp that lies in the future by more than `skew_s`: the clocks disagree, so that nobody
    knows how old the value is.
    """
    age_s = source_now_s - stamp_s
    if age_s < -skew_s:
        raise ValueError(f"its time stamp lies {-age_s:.1f} s in the future: set the clocks by one time server")
    return asked_s - max(age_s, 0.0)
