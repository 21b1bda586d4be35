"""What readers of reports with one row a characteristic have in common."""

from collections.abc import Iterable
from pathlib import Path

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Reading
from trueloop.errors import Code, Place, TrueloopError

SLACK = 1e-9


def characteristics_of(readings: Iterable[Reading]) -> tuple[Characteristic, ...]:
    """What the file asks for, each once: those with a nominal value."""
    found: dict[tuple[str, str, str], Characteristic] = {}
    for one in readings:
        key = one.characteristic, one.feature, one.axis
        if one.nominal is not None and key not in found:
            found[key] = Characteristic(
                one.characteristic, one.quantity, one.feature, one.nominal, one.lower_limit, one.upper_limit, one.other
            )
    return tuple(found.values())


def require_order(reading: Reading, path: Path) -> None:
    """Raises MSR-EXCHANGED where the lower limit is above the upper one."""
    lower, upper = reading.lower_limit, reading.upper_limit
    if lower is not None and upper is not None and lower > upper + SLACK:
        raise limits_refusal(lower, upper, Place(str(path), reading.line))


def limits_refusal(lower: float, upper: float, place: Place) -> TrueloopError:
    """The refusal of limits in the wrong order, in mm or degrees."""
    return TrueloopError(
        Code.MSR_EXCHANGED,
        f"the lower limit {lower:.6g} is above the upper one, {upper:.6g}",
        hint="are the two limits exchanged, or is a sign missing?",
        place=place,
        values={"lower": lower, "upper": upper},
    )
