"""The sizes that the drawing of a turned part specifies, from its last correction, and inspections in their names."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Inspection, Reading, Values
from trueloop.domain.part import Part
from trueloop.domain.record import Correction as StoredCorrection
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.shares import of_characteristic
from trueloop.loops.monitor.certificate import RequiredSize
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.share import characteristics_in, frame_of
from trueloop.storage.store import Store, find
from trueloop.turned.characteristics.measurand import SAME, place_of, usual
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import MatchedReading
from trueloop.turned.readings.sizes import axial_mm


@dataclass(frozen=True)
class DrawingSizes:
    """Characteristics with their limits, and the profile that has them, in the frame of the inspections kept."""

    profile: Profile
    characteristics: tuple[Characteristic, ...]

    def required(self, inspections: Iterable[Inspection]) -> tuple[RequiredSize, ...]:
        """Returns the characteristics; by general tolerances only those that `inspections`, in their names, have."""
        read = {reading.characteristic for inspection in inspections for reading in inspection.readings}
        general = {one.name for feature in self.profile.features if (one := usual(feature)) is not None}
        return tuple(
            RequiredSize(
                characteristic.name,
                characteristic.quantity,
                characteristic.nominal,
                characteristic.lower_limit,
                characteristic.upper_limit,
            )
            for characteristic in self.characteristics
            if characteristic.name in read
            or characteristic.name not in general
            or not characteristic.tolerance.startswith("ISO 2768")
        )

    def in_its_names(self, inspection: Inspection) -> Inspection:
        """Returns an inspection whose readings have names and limits of their characteristics, where they have any."""
        readings, named = list[Reading](), dict[str, set[str]]()
        for reading in inspection.readings:
            of = self._of(inspection, reading)
            readings += [of_characteristic(reading, characteristic) for characteristic in of] or [reading]
            for characteristic in of:
                named.setdefault(characteristic.name, set()).add(inspection.device_of(reading.characteristic))
        known = {name: "" if "" in devices else ", ".join(sorted(devices)) for name, devices in named.items()}
        values: Values = (*readings, *inspection.touches, *inspection.points)
        return replace(inspection, values=values, devices={**inspection.devices, **known})

    def _of(self, inspection: Inspection, reading: Reading) -> list[Characteristic]:
        """Returns the characteristics that a reading is of: by its name, else by feature and place."""
        own = [characteristic for characteristic in self.characteristics if characteristic.quantity is reading.quantity]
        if by_name := [characteristic for characteristic in own if characteristic.name == reading.characteristic]:
            return by_name
        matched = match_inspection(self.profile, replace(inspection, values=(reading,))).readings
        return [characteristic for found in matched for characteristic in own if self._is_of(found, characteristic)]

    def _is_of(self, reading: MatchedReading, characteristic: Characteristic) -> bool:
        other = "" if reading.other_index is None else self.profile.names[reading.other_index]
        as_read = replace(characteristic, feature=self.profile.names[reading.feature_index], other=other)
        z_mm = axial_mm(reading.reading)
        there = characteristic.at_z_mm is None or (z_mm is not None and abs(z_mm - characteristic.at_z_mm) < SAME)
        return there and place_of(as_read, self.profile) == place_of(characteristic, self.profile)


def drawing_of(store: Store, part: Part) -> DrawingSizes | None:
    """Returns the characteristics of a type's last correction; None: none. A file's own ones are left to the file."""
    for kept in reversed(find(store, StoredCorrection, part_type=part.part_type.name)):
        record, correction = kept.value.record, kept.value.payload
        if record.part_type is None or record.part_type.identity != part.part_type.identity:
            continue
        if not isinstance(correction, Correction) or not (record.characteristics or record.between):
            continue
        of_file = {
            (reading.characteristic, reading.lower_limit, reading.upper_limit)
            for inspection in record.inspections
            for reading in inspection.readings
        }
        drawn = [*(characteristic.characteristic for characteristic in record.characteristics), *record.between]
        own = tuple(
            characteristic
            for characteristic in drawn
            if (characteristic.name, characteristic.lower_limit, characteristic.upper_limit) not in of_file
        )
        return DrawingSizes(correction.profile, characteristics_in(frame_of(correction), own))
    return None
