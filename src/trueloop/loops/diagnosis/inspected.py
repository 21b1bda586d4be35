"""A part as it was inspected, its errors of features, and what its repeats say of its fixturing."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from trueloop.diagnosis.causes.seen_part import SeenBy, SeenPart
from trueloop.diagnosis.features.errors_of import errors_of
from trueloop.diagnosis.features.feature_place import FeaturePlace
from trueloop.diagnosis.features.seen_points import SeenPoints
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part
from trueloop.domain.standard_part import StandardPart
from trueloop.loops.diagnosis.left_on_parts import BothSeen
from trueloop.loops.diagnosis.points_of import points_of


@dataclass(frozen=True, eq=False)
class Inspected:
    """One part: how it was made, without errors; what each kind of device found; its calibration if it is standard.

    `both` is there where both devices saw the same points and the model of the machine is known.
    """

    part: Part
    made: SeenPart
    seen: Mapping[SeenBy, Inspection]
    standard: StandardPart | None = None
    both: BothSeen | None = None

    def points(self, places: Mapping[str, FeaturePlace]) -> dict[SeenBy, SeenPoints]:
        """By who saw them; of a standard part errors are actual less calibrated."""
        seen = {by: points_of(against_calibrated(one, self.standard), places) for by, one in self.seen.items()}
        return {by: points for by, points in seen.items() if points.feature}

    def with_errors(self, places: Mapping[str, FeaturePlace]) -> SeenPart:
        """As a diagnosis of causes takes it."""
        points = self.points(places)
        errors = {by: errors_of(some, places) for by, some in points.items()}
        return replace(self.made, errors=errors, points=points)


def against_calibrated(one: Inspection, standard: StandardPart | None) -> Inspection:
    """An inspection whose readings are off nominal by as much as they are off their calibrated values.

    Errors count from the nominal shape: a calibrated part is not nominal itself. Readings without a calibrated value,
    or of which neither has the nominal one, are left out.
    """
    if standard is None:
        return one
    known = {value.characteristic: value for value in standard.values}
    values = []
    for value in one.values:
        if isinstance(value, Reading) and (calibrated := known.get(value.characteristic)) is not None:
            nominal = calibrated.nominal if value.nominal is None else value.nominal
            if nominal is not None:
                actual = value.actual - calibrated.actual + nominal
                values.append(replace(value, actual=actual, nominal=nominal))
    return replace(one, values=tuple(values), count=len(values))
