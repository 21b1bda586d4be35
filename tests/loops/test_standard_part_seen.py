"""A standard part is not nominal itself: what a probe finds counts from its calibration."""

from trueloop.diagnosis.causes.cause import SeenBy, SeenPart
from trueloop.diagnosis.features.feature_error import ErrorKind
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading, StandardPart
from trueloop.domain.part import Part, PartType
from trueloop.loops.diagnosis.part import InspectedPart, against_calibrated
from trueloop.loops.diagnosis.points_of import places_of

PART = Part(PartType("master"), "M1")
CALIBRATED = StandardPart(PART, (Reading("D", Quantity.DIAMETER, 50.010, 50.0, feature="shaft"),))


def found(actual_mm: float, nominal_mm: float | None = 50.0, name: str = "D") -> Inspection:
    reading = Reading(name, Quantity.DIAMETER, actual_mm, nominal_mm, feature="shaft", place_mm=(-20.0,))
    return Inspection(PART, "readings", "00", 1, (reading,), "probe")


def test_errors_of_a_standard_part_count_from_its_calibrated_values() -> None:
    seen = found(50.022)
    inspected = InspectedPart(PART, SeenPart("M1", 0, {}, standard=True), {SeenBy.MACHINE: seen}, CALIBRATED)
    errors = inspected.with_errors(places_of([seen])).errors[SeenBy.MACHINE]
    radius = next(one for one in errors if one.kind is ErrorKind.RADIUS)
    assert abs(radius.value_mm - 0.006) < 1e-9  # 12 µm above calibrated on the diameter


def test_the_nominal_value_may_be_that_of_the_calibration() -> None:
    (reading,) = against_calibrated(found(50.022, None), CALIBRATED).readings
    assert reading.nominal == 50.0
    assert abs(reading.actual - 50.012) < 1e-9


def test_a_size_that_is_not_calibrated_says_nothing() -> None:
    assert against_calibrated(found(50.022, name="other"), CALIBRATED).values == ()
