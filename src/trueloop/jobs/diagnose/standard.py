"""Standard parts: calibrated values from an inspection file, kept."""

from datetime import datetime
from pathlib import Path

from trueloop.domain.inspection import Reading, StandardPart
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import Stated
from trueloop.jobs.store.keep_facts import KeptFacts, keep_facts
from trueloop.storage.store import Store

STANDARD_C = 20.0
WITHIN_K = 2.0
"""ISO 1: sizes hold at 20 °C; further away a calibration needs the part's expansion, which is not known here."""


def keep_standard(
    store: Store, path: Path, part: Part, stated: Stated, by: str = "", *, supersede: bool = False
) -> KeptFacts:
    """Keeps the calibrated values of a file of one part.

    Raises MSR errors; DIA-STANDARD for a file of several parts, of another part, without sizes, of sizes without an
    uncertainty, or measured away from 20 °C.
    """
    inspections = read_measured_file(path, stated).inspections
    if len(inspections) != 1:
        raise _refused(path, f"it holds {len(inspections)} inspections", "give a file of one part's calibration")
    one = inspections[0]
    if one.part.serial and one.part.serial != part.serial:
        raise _refused(path, f"it is of part {one.part.serial!r}, not of {part.serial!r}", "name the part of the file")
    values = tuple(value for value in one.readings if value.characteristic)
    _require_calibrated(path, values)
    temperature = _temperature(path, one.temperatures, values)
    at: datetime | None = one.measured_at
    kept = StandardPart(part, values, at, by or one.operator, temperature)
    return keep_facts(store, (part, kept), _coarse(values), supersede=supersede)


def standard_of(part_type: str, serial: str) -> Part:
    """Makes a part from its names."""
    return Part(PartType(part_type), serial)


def _require_calibrated(path: Path, values: tuple[Reading, ...]) -> None:
    if not values:
        raise _refused(path, "it holds 0 sizes", "a calibration states sizes: diameters, lengths, each with its name")
    without = [value.characteristic for value in values if not value.standard_u]
    if without:
        listed = ", ".join(without[:5])
        hint = "add the standard uncertainty that the certificate states, of each size"
        raise _refused(path, f"{len(without)} of {len(values)} sizes have no uncertainty: {listed}", hint)


def _temperature(path: Path, by_sensor: object, values: tuple[Reading, ...]) -> float:
    stated = [value.temperature_c for value in values if value.temperature_c is not None]
    if isinstance(by_sensor, dict):
        stated += [float(value) for value in by_sensor.values()]
    found = STANDARD_C if not stated else sum(stated) / len(stated)
    if abs(found - STANDARD_C) > WITHIN_K:
        hint = "calibrate at 20 ± 2 °C, the temperature at which sizes hold (ISO 1)"
        raise _refused(path, f"it was measured at {found:.1f} °C", hint)
    return found


def _coarse(values: tuple[Reading, ...]) -> list[Finding]:
    """Sizes known worse than a probe repeats."""
    coarse = [value.characteristic for value in values if (value.standard_u or 0.0) > 0.002]
    if not coarse:
        return []
    message = f"{len(coarse)} sizes are known to more than 2 µm: {', '.join(coarse[:5])}"
    hint = "a probe offset smaller than that cannot be told from the calibration"
    return [Finding(Severity.NOTE, Code.DIA_STANDARD, message, hint)]


def _refused(path: Path, why: str, hint: str) -> TrueloopError:
    return Code.DIA_STANDARD.refusal(f"no calibration of a standard part: {why}", hint=hint, place=Place(str(path)))
