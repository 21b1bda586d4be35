"""Parts of series for tests: inspections of characteristics, as a measuring machine would report them."""

from collections.abc import Mapping
from datetime import UTC, datetime, timedelta

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.loops.post_process.series import PartSeen, series_of
from trueloop.loops.post_process.tracked import TrackedSeries, tracked

MADE = datetime(2026, 3, 1, 8, tzinfo=UTC)
NOMINAL_MM = 24.0


def reading(name: str, error_um: float, nominal_mm: float = NOMINAL_MM, half_zone_um: float | None = 30.0) -> Reading:
    """A diameter with an error, its limits about the nominal."""
    zone = None if half_zone_um is None else half_zone_um / 1000
    return Reading(
        name,
        Quantity.DIAMETER,
        nominal_mm + error_um / 1000,
        nominal_mm,
        None if zone is None else nominal_mm - zone,
        None if zone is None else nominal_mm + zone,
        feature="journal",
    )


def inspection(
    serial: str, errors_um: Mapping[str, float], *, hours: float | None = None, sha256: str = ""
) -> Inspection:
    """A part with diameters of these errors, µm, measured so many hours after the first."""
    values = tuple(reading(name, error) for name, error in errors_um.items())
    at = None if hours is None else MADE + timedelta(hours=hours)
    part = Part(PartType("SHAFT"), serial)
    return Inspection(part, "readings", sha256 or f"file-{serial}", len(values), values, measured_at=at)


def seen(*errors_um: float, name: str = "journal") -> tuple[PartSeen, ...]:
    """Parts 1, 2, … of one diameter."""
    return tuple(PartSeen(inspection(str(k), {name: error})) for k, error in enumerate(errors_um, 1))


def followed(*errors_um: float, name: str = "journal") -> TrackedSeries:
    """The series of these parts, followed."""
    (series,) = series_of(seen(*errors_um, name=name))
    return tracked(series)
