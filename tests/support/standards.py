"""A calibrated ring and its checks by a gauge, as tests need them."""

from collections.abc import Sequence
from datetime import UTC, datetime, timedelta

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading, StandardPart
from trueloop.domain.part import Part, PartType

RING = Part(PartType("RING 40"), "R7")
CALIBRATED_MM = 40.0012
CALIBRATION_U_MM = 0.0003
FIRST = datetime(2026, 3, 1, 7, tzinfo=UTC)
STANDARD = StandardPart(
    RING, (Reading("bore", Quantity.DIAMETER, CALIBRATED_MM, standard_u=CALIBRATION_U_MM),), FIRST - timedelta(days=30)
)


def check(
    day: float, *deviations_um: float, device: str = "bore gauge", u_um: float | None = 0.5, part: Part = RING
) -> Inspection:
    """Repeats of the ring's bore on a day, each off by so much."""
    at = FIRST + timedelta(days=day)
    values = tuple(
        Reading(
            "bore",
            Quantity.DIAMETER,
            CALIBRATED_MM + off / 1000,
            40.0,
            repeat=k,
            standard_u=None if u_um is None else u_um / 1000,
        )
        for k, off in enumerate(deviations_um, 1)
    )
    return Inspection(part, "readings", f"check {device} {day:g}", len(values), values, device, measured_at=at)


def checks(deviations_um: Sequence[float], **more: str) -> list[Inspection]:
    """One check a day."""
    return [check(day, off, **more) for day, off in enumerate(deviations_um)]  # type: ignore[arg-type]
