"""A milled part's job: read with its measurements, answered with numbers to enter at the control, and recorded."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from os.path import relpath
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading, index_of_name
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, in_file
from trueloop.estimate.places import together
from trueloop.formats.input_file import FilePath, read_input
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.formats.jobs.milled_job import MeasuredTable, MilledJobFile, read_milled_job
from trueloop.jobs.milled_new import CutFeatures, cut_features
from trueloop.jobs.user import user_name
from trueloop.milled.entries import Proposal, ProposedEntry, propose
from trueloop.milled.entry import PLAINEST, Entered, Entry, Part, Register
from trueloop.milled.feature import MilledFeature
from trueloop.milled.observed import Device, Frame, by_depth, observed_of, require_not_exchanged, seen
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.units import MM_PER_INCH, UM_PER_MM
from trueloop.wording import first_of, wording

RECORD: Final = "entries.json"
Changes: TypeAlias = dict[str, Entered]
"""The changes of each record that is in force, by the record's digest."""
_Read: TypeAlias = tuple[Reading, str]
"""A reading, and the device that it is of."""
LARGEST_CHANGE: Final = 10.0
"""The largest change, mm or rad, that a record may hold."""
KIND: Final = "trueloop entries of a milled part"


@dataclass(frozen=True)
class EnteredValue:
    """A number as it is typed: `name` of its register as the program calls it, or its work offset; `holds`, the
    quantity there (`diameter` of a register that counts these); its change, the total since the first part and the
    standard uncertainty in the control's unit, `mm`, `in` or `deg`.
    """

    name: str
    holds: str
    change: float
    total: float
    standard_u: float
    unit: str


@dataclass(frozen=True, eq=False)
class MilledJob:
    """A job as values: `files` read, `unused` readings by name, `changes` in force on the last part."""

    name: str
    parts: tuple[Part, ...]
    inspections: tuple[Inspection, ...]
    changes: Changes
    possible: tuple[Entry, ...]
    cut: CutFeatures
    unused: tuple[str, ...]
    files: tuple[Path, ...]
    job: MilledJobFile
    path: Path

    @property
    def folder(self) -> Path:
        """Returns the folder of the results."""
        return self.path.parent / self.job.output.folder

    @property
    def control_unit(self) -> Literal["mm", "inch"]:
        """Returns the unit that the control counts in: its program's, without one the job's."""
        inch = self.job.unit == "inch" if self.cut.inch is None else self.cut.inch
        return "inch" if inch else "mm"

    @property
    def step_mm(self) -> float:
        """Returns the step of the control's offsets: 0.001 mm, 0.0001 inch."""
        return 1e-4 * MM_PER_INCH if self.control_unit == "inch" else 1e-3

    def as_entered(self, entry: ProposedEntry) -> EnteredValue:
        """Returns what is typed for a number."""
        register, of = entry.entry.register, entry.entry.of
        called = {"radius": self.cut.radius_words, "length": self.cut.length_words}
        name, holds = called[register].get(of, "") if register in called else of, str(register)
        unit, scale = ("in", 1.0 / MM_PER_INCH) if self.control_unit == "inch" else ("mm", 1.0)
        if register == "turn":
            unit, scale = "deg", math.degrees(1.0)
        elif register == "radius" and of in self.cut.diameters:
            holds, scale = "diameter", 2.0 * scale
        change, total, u = (value * scale for value in (entry.change, entry.total, entry.standard_u))
        return EnteredValue(name, holds, change=change, total=total, standard_u=u, unit=unit)


def read_milled(path: FilePath) -> MilledJob:
    """Reads a job, its measurements and the records in force. Raises JOB, MSR and MIL errors.

    >>> plate = trueloop.read_milled(trueloop.example("plate/plate.toml"))
    >>> plate.name, len(plate.parts)
    ('plate', 1)
    """
    path = Path(path)
    job = read_milled_job(path)
    with in_file(path):
        _require_facts(job)
        cut = cut_features(path, job)
    frame = Frame(job.frame.x, job.frame.y, job.frame.z, job.frame.turn)
    parts, unused, files, changes = list[Part](), dict[str, None](), [path], Changes()
    inspections = list[Inspection]()
    files += [] if job.program is None else [path.parent / job.program.file]
    for table in job.measured:
        records = [path.parent / one for one in table.entered or ()]
        changes = _changes(records, job.name)
        in_force = dict[Entry, float]()
        for entry, change in (pair for mapping in changes.values() for pair in mapping.items()):
            in_force[entry] = in_force.get(entry, 0.0) + change
        # Raises MIL-RECORD for an entry that moves nothing here, where its tool cuts features by other means, or where
        # no feature is cut from its work offset: it would count as never entered.
        features = tuple(cut.features.values())
        for entry, total in in_force.items():
            if entry.register in ("radius", "length"):
                own = [feature for feature in features if str(feature.tool) == entry.of]
                moved = not own or any(getattr(feature, f"{entry.register}_at_control") for feature in own)
            else:
                moved = any(feature.work_offset == entry.of for feature in features)
            if total != 0.0 and not moved:
                raise _bad_record(
                    records[-1], f"and those before enter {entry.words}, which moves no feature of the job"
                )
        file = path.parent / table.file
        files += [file, *records, *([] if table.mapping is None else [path.parent / table.mapping])]
        found = list(_inspections(path, table))
        inspections += found
        for serial, readings in _by_part(iter(found)):
            before = (
                parts[-1] if parts and serial and (parts[-1].serial, parts[-1].in_force) == (serial, in_force) else None
            )
            number = len(parts) if before is None else len(parts) - 1
            with in_file(file):
                part, without = _part(job, cut.features, frame, (serial or str(number + 1), readings), in_force, number)
            unused.update(dict.fromkeys(without))
            if before is None:
                parts.append(part)
            else:  # two devices
                shown, observed = (*before.shown, *part.shown), together([before.observed, part.observed])
                parts[-1] = replace(before, shown=by_depth(shown), observed=observed)
    with in_file(path):
        _require_devices(job, {name for part in parts for name in part.observed.places.columns["device"].tolist()})
    return MilledJob(
        name=job.name,
        parts=tuple(parts),
        inspections=tuple(inspections),
        changes=changes,
        possible=_possible(job, cut),
        cut=cut,
        unused=tuple(unused),
        files=tuple(files),
        job=job,
        path=path,
    )


def _possible(job: MilledJobFile, cut: CutFeatures) -> tuple[Entry, ...]:
    """Returns the numbers that the control can be given, work offsets of the measurement's datums last."""
    features = cut.features.values()
    offsets = dict.fromkeys(feature.work_offset for feature in features)
    turns = job.rotation and len(offsets) == 1  # each turns about a zero of its own, which the job does not state
    registers: tuple[Register, ...] = ("x", "y", "z", "turn") if turns else ("x", "y", "z")
    datums = {job.frame.x, job.frame.y, job.frame.z, *(job.frame.turn or ())}
    of_datums = {feature.work_offset for feature in features if feature.name in datums}
    return (
        *(Entry("radius", str(n)) for n in sorted({feature.tool for feature in features if feature.radius_at_control})),
        *(Entry("length", str(n)) for n in sorted({feature.tool for feature in features if feature.length_at_control})),
        *(Entry(register, name) for name in sorted(offsets, key=of_datums.__contains__) for register in registers),
    )


def entries_for_next_part(job: MilledJob) -> Proposal:
    """Returns the numbers to enter before the next part. Raises MIL-ENTRY for a change above the job's limits.

    >>> plate = trueloop.read_milled(trueloop.example("plate/plate.toml"))
    >>> for entry in trueloop.entries_for_next_part(plate).proposed[:3]:
    ...     print(entry.entry.words, round(entry.change, 3))  # mm, rad of a rotation
    tool 2, radius -0.02
    G54, X -0.03
    tool 1, radius 0.012
    """
    with in_file(job.path):
        found = propose(job.name, job.parts, job.possible, job.step_mm, [table.name for table in job.job.device])
    for entry in found.proposed:
        turn = entry.entry.register == "turn"
        unit, scale = ("µrad", 1e6) if turn else ("µm", UM_PER_MM)
        limit = job.job.limits.turn_urad if turn else job.job.limits.entry_um
        if abs(entry.change) * scale > limit:
            key = "limits.turn_urad" if turn else "limits.entry_um"
            raise Code.MIL_ENTRY.refusal(
                wording(
                    "{entry} would change by {change:+.0f} {unit}, the limit is {limit:g}",
                    entry=entry.entry.words,
                    change=entry.change * scale,
                    unit=unit,
                    limit=limit,
                ),
                hint="look at the readings first: a wrong work offset, an exchanged tool or features under names of "
                "others look like this",
                place=Place(str(job.path)),
                override=f"a larger `{key}` in the job",
                values={"entry": entry.entry.words, "change": entry.change * scale, "limit": limit},
            )
        if entry.entry.register == "radius":
            with in_file(job.path):
                job.cut.require_room(entry.entry.of, entry.total)
    return found


def record_of(job: MilledJob, proposal: Proposal) -> bytes:
    """Returns the record of the numbers, with those in force before, as a later job's `measured.entered` names it."""
    about = {
        "kind": KIND,
        "part_type": job.name,
        "made_at": datetime.now(UTC).isoformat(timespec="seconds"),
        "made_by": user_name(),
        "inputs": {Path(relpath(file, job.path.parent)).as_posix(): sha256_of(file.read_bytes()) for file in job.files},
        "before": {digest: [_stated(*pair) for pair in mapping.items()] for digest, mapping in job.changes.items()},
        "entries": [
            {**_stated(entry.entry, entry.change), "total": entry.total, "standard_u": entry.standard_u}
            for entry in proposal.proposed
        ],
    }
    return (json.dumps(about, ensure_ascii=False, indent=2) + "\n").encode()


def _require_facts(job: MilledJobFile) -> None:
    """Raises MIL-ENTERED where it is not stated what had been entered when a later part was cut."""
    for k, table in enumerate(job.measured[1:], 2):
        if table.entered is None:
            raise Code.MIL_ENTERED.refusal(
                f"measurement {k} of {len(job.measured)}, {table.file.name!r}: it is not stated which numbers had been "
                "entered when its parts were cut",
                hint=f'add to its [[measured]] `entered = ["out/{RECORD}"]`, the latest record, or `entered = []`',
                values={"measurement": k, "file": table.file.name},
            )


def _inspections(path: Path, table: MeasuredTable) -> Iterator[Inspection]:
    """Yields the parts of a file. Raises MSR-NONE where it has no value, MSR-SERIAL where the serial number that is
    chosen is not in it.
    """
    file = path.parent / table.file
    mapping = None if table.mapping is None else path.parent / table.mapping
    measured = read_measured_file(file, StatedFacts(table.unit, mapping, "measured.unit"))
    found = measured.inspections
    if not found:
        hint = "fill in at least one value: a row without one was not measured"
        raise Code.MSR_NONE.refusal(f"{file.name!r} holds 0 values", hint=hint, place=Place(str(file)))
    alone = len(found) == 1 and not found[0].part.serial  # the job alone states its serial number
    chosen = [inspection for inspection in found if alone or table.serial in (None, inspection.part.serial)]
    if not chosen:
        serials = [inspection.part.serial for inspection in found]
        raise Code.MSR_SERIAL.refusal(
            f"{file.name!r} has no part {table.serial!r}; its {len(serials)} parts are {', '.join(serials[:20])}",
            hint="correct `measured.serial`, or leave it out for all parts of the file",
            place=Place(str(file)),
            values={"serials": serials[:20]},
        )
    for inspection in chosen:
        stated = {} if table.device is not None else inspection.devices
        part = replace(inspection.part, serial=inspection.part.serial or table.serial or "")
        yield replace(
            inspection, part=part, device=table.device or inspection.device or measured.format, devices=stated
        )


def _by_part(inspections: Iterator[Inspection]) -> Iterator[tuple[str, list[_Read]]]:
    """Yields serial numbers and readings with their devices: runs of a file that state one serial number are of one
    part.

    What was measured in the frame of the machine, or of the device, holds no positions in the part's.
    """
    found = list[tuple[str, list[_Read]]]()
    for inspection in inspections:
        readings = [
            (each, inspection.device_of(each.characteristic))
            for each in inspection.readings
            if inspection.frame == "part" or each.quantity is not Quantity.POSITION
        ]
        if found and inspection.part.serial and found[-1][0] == inspection.part.serial:
            found[-1][1].extend(readings)
        else:
            found.append((inspection.part.serial, readings))
    yield from found


def _part(
    job: MilledJobFile,
    features: dict[str, MilledFeature],
    frame: Frame,
    measured: tuple[str, list[_Read]],
    in_force: Entered,
    number: int,
) -> tuple[Part, list[str]]:
    serial, readings = measured[0], [_renamed(reading, job.names, tuple(features)) for reading, _ in measured[1]]
    pairs = [(reading, seen(features, frame, reading)) for reading in readings]
    used = [(reading, what) for reading, what in pairs if what is not None]
    calibrated = _calibrated(job)
    devices = [
        calibrated.get(name, Device(name))
        for (_, name), (_, what) in zip(measured[1], pairs, strict=True)
        if what is not None
    ]
    if not used:
        measured_names = sorted({reading.feature for reading in readings})[:20]
        unknown = [one for one in readings if one.quantity is Quantity.OTHER and one.feature in features]
        raise Code.MIL_NONE.refusal(
            wording(
                "none of {n} readings of part {serial!r} is a size or coordinate of a feature of the job; the "
                "file's features are {names}",
                n=len(readings),
                serial=serial,
                names=", ".join(map(repr, measured_names)) or "not named",
            ),
            hint="state what they are the sizes of, by a column of quantities or in the heading of the values: "
            f"{unknown[0].characteristic!r} names none of `Ø`, `Diameter`, `Length`, `X` …"
            if unknown
            else 'give the job\'s names in the table [names]: `CIR1 = "B1"`',
            values={"readings": len(readings), "features": measured_names},
        )
    require_not_exchanged(used)
    for reading, what in used:
        off_um = (reading.actual - what.nominal_mm) * UM_PER_MM
        if abs(off_um) > job.limits.deviation_um:
            raise Code.MIL_LARGE.refusal(
                wording(
                    "{name} of part {serial!r} deviates by {off_um:+.0f} µm, the limit is {limit_um:g} µm",
                    name=what.name,
                    serial=serial,
                    off_um=off_um,
                    limit_um=job.limits.deviation_um,
                ),
                hint="look whether it is that feature: a bore taken for a boss, another work offset or unit, a chip",
                override="a larger `limits.deviation_um` in the job",
                values={"name": what.name, "deviation_um": off_um, "limit_um": job.limits.deviation_um},
            )
    shown = by_depth([what for _, what in used])
    u_mm = job.measuring_u_um / UM_PER_MM
    observed = observed_of(shown, [reading for reading, _ in used], (job.name, number), u_mm, devices)
    return Part(serial, shown, observed, in_force), [reading.characteristic for reading, what in pairs if what is None]


def _calibrated(job: MilledJobFile) -> dict[str, Device]:
    """Returns the devices that measured a ring gauge, by name: a ring that reads small has its wall too far out."""
    per = MM_PER_INCH if job.unit == "inch" else 1.0
    return {one.name: Device(one.name, 0.5 * per * (one.ring - one.ring_measured)) for one in job.device}


def _require_devices(job: MilledJobFile, measured: set[str]) -> None:
    """Raises MIL-DEVICE for a ring gauge of a device that measured nothing, MIL-LARGE for one read too far off."""
    for device in _calibrated(job).values():
        off_um, limit_um = UM_PER_MM * device.off_mm, job.limits.deviation_um
        if device.name not in measured:
            devices = sorted(measured)
            raise Code.MIL_DEVICE.refusal(
                f"{device.name!r} measured a ring gauge and none of the parts; they were measured by "
                f"{', '.join(map(repr, devices))}",
                hint="correct `device.name`, or state `measured.device` of the file that is of it",
                values={"device": device.name, "devices": devices},
            )
        if abs(off_um) > limit_um:
            name = f"the wall of the ring gauge, as {device.name!r} reads it,"
            raise Code.MIL_LARGE.refusal(
                f"{name} deviates by {off_um:+.0f} µm, the limit is {limit_um:g} µm",
                hint="state diameters in `device.ring` and `device.ring_measured`, in the job's unit, or calibrate it",
                override="a larger `limits.deviation_um` in the job",
                values={"name": name, "deviation_um": off_um, "limit_um": limit_um},
            )


def _renamed(reading: Reading, listed: Mapping[str, str], features: tuple[str, ...]) -> Reading:
    """Returns a reading with the job's names of its features: as `[names]` lists them, else as they are written."""

    def own(name: str) -> str:
        k = index_of_name(tuple(listed), name)
        if k is not None:
            return list(listed.values())[k]
        k = index_of_name(features, name)
        return name if k is None else features[k]

    return replace(reading, feature=own(reading.feature), other=own(reading.other))


def _changes(records: Sequence[Path], part_type: str) -> Changes:
    """Returns the changes of records and of all in force before them. Raises MIL-RECORD for any other file."""
    changes, named = Changes(), set[str]()
    for path in records:
        content = read_input(path, Code.MIL_RECORD, hint=f"name the {RECORD} that an earlier job has written")
        digest, own = _changes_of(path, content, part_type)
        if digest in named:
            raise _bad_record(path, "is named twice, or was written twice")
        named.add(digest)
        changes |= own
    return changes


def _changes_of(path: Path, content: bytes, part_type: str) -> tuple[str, Changes]:
    """Returns the digest of a record, and the changes of that record and of those before it."""
    try:
        about: Any = json.loads(content)
        if about["kind"] != KIND:
            raise _bad_record(path, f"is of another kind, {about['kind']!r}")
        if about["part_type"] != part_type:
            raise _bad_record(path, f"is of the part {about['part_type']!r}, the job of {part_type!r}")
        made = json.dumps({name: value for name, value in about.items() if not name.startswith("made_")})
        digest = sha256_of(made.encode())
        listed = {**about["before"], digest: about["entries"]}
        return digest, {key: dict(_entry_of(path, one) for one in every) for key, every in listed.items()}
    except (ValueError, KeyError, TypeError, OverflowError, RecursionError) as error:
        raise _bad_record(path, f"is not a record of entries: {type(error).__name__}") from error


def _stated(entry: Entry, change: float) -> dict[str, object]:
    """Returns a change as a record states it; `_entry_of` reads it."""
    unit = "rad" if entry.register == "turn" else "mm"
    return {"register": entry.register, "of": entry.of, "change": change, "unit": unit}


def _entry_of(path: Path, stated: Any) -> tuple[Entry, float]:
    register, of, change, unit = (stated[name] for name in ("register", "of", "change", "unit"))
    known = register in PLAINEST and isinstance(of, str) and unit == ("rad" if register == "turn" else "mm")
    if not known or not isinstance(change, (int, float)) or not abs(change) < LARGEST_CHANGE:
        raise _bad_record(path, f"states an entry that no job has written: {str(stated)[:120]}")
    return Entry(register, of), float(change)


def _bad_record(path: Path, why: str) -> Exception:
    return Code.MIL_RECORD.refusal(
        f"{path.name!r} {why}",
        hint=f"name the latest {RECORD} whose numbers were entered: it holds those before it",
        place=Place(str(path)),
    )


def entry_lines(job: MilledJob, proposal: Proposal, say: Texts = ENGLISH) -> list[str]:
    """Returns a line for each number, in the unit of the control and of its register, and the RMS with all of them."""
    before, after = (UM_PER_MM * value for value in proposal.rms_mm)
    lines = [_entry_line(job, entry, say) for entry in proposal.proposed]
    nothing = [] if lines else [say("nothing to enter: no number is known to be off")]
    rms = say(
        "expected deviation, RMS: {before:.1f} µm unchanged, {after:.1f} µm with these numbers",
        before=before,
        after=after,
    )
    return [*lines, *nothing, rms]


def _entry_line(job: MilledJob, entry: ProposedEntry, say: Texts) -> str:
    """Returns what to type; in the job's unit beside it where it differs from the control's."""
    typed, in_tool = job.as_entered(entry), entry.entry.register in ("radius", "length")
    unit, decimals = {"mm": (" mm", 3), "in": (" in", 4), "deg": ("°", 3)}[typed.unit]

    def number(value: float, spec: str) -> str:
        return say.spelled(f"{value:{spec}}")

    change = f"{number(typed.change, f'+.{decimals}f')}{unit}"
    if typed.unit != "deg" and job.control_unit != job.job.unit:
        own, per = ("in", 1.0 / MM_PER_INCH) if typed.unit == "mm" else ("mm", MM_PER_INCH)
        change += f" = {number(typed.change * per, f'+.{8 - decimals}f')} {own}"
    line = say(
        "{register}: add {change} (± {u})",
        register=_named(entry.entry, typed.holds, say) + (f" ({typed.name})" if in_tool and typed.name else ""),
        change=change,
        u=f"{number(2.0 * typed.standard_u, f'.{decimals + 1}f')}{unit}",
    )
    if entry.change == entry.total:
        return line
    return line + say("; since the first part {total}", total=f"{number(typed.total, f'+.{decimals}f')}{unit}")


def _named(entry: Entry, holds: str, say: Texts) -> str:
    """Names a register; `holds` is the quantity that stands there of a tool."""
    if entry.register in ("radius", "length"):
        quantities = {"radius": say("radius"), "diameter": say("diameter"), "length": say("length")}
        return say("tool {tool}, {quantity}", tool=entry.of, quantity=quantities[holds])
    if entry.register == "turn":
        return say("{offset}, rotation about Z", offset=entry.of)
    return f"{entry.of}, {entry.register.upper()}"


def proposal_notes(job: MilledJob, proposal: Proposal, say: Texts = ENGLISH) -> Iterator[str]:
    """Yields notes on readings that the numbers leave out, and on numbers that rest on one reading."""
    for name in proposal.unlike:
        yield say(
            "{name}: far off what tools and work offsets explain; it has no part in these numbers, measure it again",
            name=name,
        )
    for each in proposal.contradictory:
        low, high = (say.spelled(f"{UM_PER_MM * value:+.1f}") for value in each.between_mm)
        yield say(
            "{names}: {n} readings on part '{serial}', {low} to {high} µm{counted}, contradict each other; they have "
            "no part in these numbers, measure it again",
            names=say(" and ").join(each.names),
            n=each.readings,
            serial=each.serial,
            low=low,
            high=high,
            counted="" if len(each.names) == 1 else say(" as {name}", name=each.names[0]),
        )
    for both in proposal.exchanged:
        yield say(
            "{names} of part '{serial}' fit when their readings are exchanged; they have no part in these numbers: "
            "look at their names",
            names=say(" and ").join(both.names),
            serial=both.serial,
        )
    for device in proposal.devices:
        yield say(
            "'{device}' may read all walls {off} ± {u} µm out of the material ({p} %), as with a ball that was not "
            "calibrated; tools whose radii are off alike look so too: measure a ring gauge with it and state that in a "
            "table [[device]], or measure bores and bosses with another device",
            device=device.name,
            off=say.spelled(f"{UM_PER_MM * device.off_mm:+.0f}"),
            u=say.spelled(f"{2.0 * UM_PER_MM * device.standard_u_mm:.0f}"),
            p=say.spelled(f"{100.0 * device.probability:.0f}"),
        )
    if proposal.suspected:
        yield say(
            "part '{serial}' is off {slip}; so little may be scatter: look at the control before anything is entered",
            serial=job.parts[-1].serial,
            slip=proposal.suspected,
        )
    for entry, name in proposal.by_one_reading.items():
        yield say(
            "{register}: only {name} shows it, read once; a chip there would be entered too: measure it a second time",
            register=_named(entry, entry.register, say),
            name=name,
        )
    for name in job.cut.stated:
        yield say("{name}: not in the program; tool and work offset are as stated", name=name)
    if job.unused:
        names = first_of(job.unused, 10)
        yield say("{n} readings show no size or coordinate of a feature: {names}", n=len(job.unused), names=names)
