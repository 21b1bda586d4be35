"""A corrector that works, as `trueloop realtime watch` tells the service of it."""

from math import sin
from typing import Any, Final

SIGNALS: Final = ("spindle", "bed")


def stretches(count: int = 60, first: int = 0) -> list[dict[str, Any]]:
    """Tenths of a second; x moves and its correction with it, and in the last of forty a signal is bad."""
    return [_stretch(k) for k in range(first, first + count)]


def trace(record: str = "20260102-080000", count: int = 60, first: int = 0) -> dict[str, Any]:
    """What is posted of them."""
    return {"record": record, "axes": "xz", "signals": list(SIGNALS), "stretches": stretches(count, first)}


def _stretch(k: int) -> dict[str, Any]:
    x = 20.0 + 5.0 * sin(k / 10)
    middle = {"command_x_mm": x, "command_z_mm": -0.5 * k, "correction_x_um": 0.3 * x, "correction_z_um": -1.0}
    middle |= {"model_x_um": 0.2 * x, "model_z_um": -1.0, "table_x_um": 0.1 * x, "table_z_um": 0.0}
    middle |= {"spindle": 21.0 + 0.01 * k, "bed": 20.0}
    bad = k % 40 == 39
    state = "signal spindle is stale" if bad else "correcting"
    return {
        "from_s": 0.1 * k,
        "to_s": 0.1 * (k + 1),
        "low": {name: value - 0.05 for name, value in middle.items()} | {"following_error_x_um": None},
        "high": {name: value + 0.05 for name, value in middle.items()} | {"following_error_x_um": None},
        "alarm": bad,
        "said": {"state": state, "line": str(k), "periods": "100 / 0"},
    }
