"""The stored parts of a type for a diagnosis: the devices that measured each, and its cut.

Parts that were inspected on their machine and on a measuring machine, from a store.

Standard parts: calibrated values from an inspection file, kept.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from trueloop.diagnosis.causes.cause import SeenBy
from trueloop.diagnosis.components import Inspections
from trueloop.domain.inspection import BothInspections, CmmPoint, Inspection, MachineStood, Reading, StandardPart, Touch
from trueloop.domain.life import Cut, Identity, InspectionLink, Quarantine, Stage
from trueloop.domain.part import Part, PartType, WholePart, joined_shares, whole_of
from trueloop.domain.record import Correction, sha256_of
from trueloop.errors import Code, Finding, Place, Severity, TrueloopError
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.formats.tables.model_file import read_model
from trueloop.jobs.store.history import by_own_probe
from trueloop.jobs.store.keep_facts import KeptFacts, keep_facts
from trueloop.loops.diagnosis.left_on_parts import BothSeen, states_of
from trueloop.loops.monitor.certificate import on_the_machine
from trueloop.machine.model.model import MachineModel, State
from trueloop.storage.store import Kept, Store, find
from trueloop.wording import did_you_mean


@dataclass(frozen=True)
class Records:
    """The records of one part type. `cuts` are finish cuts by part, `corrections` by id; all oldest first."""

    part_type: str
    inspections: tuple[Kept[Inspection], ...]
    links: Mapping[Identity, InspectionLink]
    cuts: Mapping[Identity, Cut]
    early: frozenset[Identity]
    quarantined: frozenset[Identity]
    both: tuple[BothInspections, ...]
    standards: Mapping[Identity, StandardPart]
    corrections: Mapping[str, Correction[Any]]

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """Returns the parts of which a finished surface was inspected, without those in quarantine."""
        found = {
            inspection.part.identity: inspection.part
            for inspection in (kept.value for kept in self.inspections)
            if self.seen_by(inspection)
        }
        return tuple(part for identity, part in found.items() if identity not in self.out)

    @cached_property
    def out(self) -> frozenset[Identity]:
        """Parts whose finish cut is in quarantine."""
        return frozenset(part for part, cut in self.cuts.items() if cut.identity in self.quarantined)

    @property
    def tools(self) -> tuple[str, ...]:
        """Names of the tools that finished the parts."""
        return tuple(dict.fromkeys(name for name in map(tool_of, self.cuts.values()) if name))

    def seen_by(self, inspection: Inspection) -> SeenBy | None:
        """Returns the kind of device that inspected it as a finished part; None: it was not finished yet.

        Stated by both inspections kept together, or by a link to a cut, of a part that was not released by its device
        as well: sizes that no probe read are a gauge's. Else touches are the machine's,
        anything else a gauge's or a measuring machine's.
        """
        if any(inspection.identity == both.on_machine for both in self.both):
            return SeenBy.MACHINE
        if any(inspection.identity == both.on_cmm for both in self.both):
            return SeenBy.CMM
        if self._reported(inspection):
            return None
        link = self.links.get(inspection.identity)
        if link is not None:
            by_gauge = inspection.measured == "readings" and not on_the_machine(inspection)
            return None if link.cut in self.early else SeenBy.CMM if link.released or by_gauge else SeenBy.MACHINE
        return SeenBy.MACHINE if inspection.measured == "touches" else SeenBy.CMM

    def _reported(self, inspection: Inspection) -> bool:
        """Returns whether the machine's own probe reported a finished part with an error that nothing tells."""
        cut, made = self.cuts.get(inspection.part.identity), self.corrections
        before = None if cut is None else made.get(cut.correction)
        if before is None or not by_own_probe(before, inspection):
            return False
        return not any(inspection in correction.record.inspections for correction in made.values())

    def of_part(self, part: Part) -> Mapping[SeenBy, Inspection]:
        """Returns a finished part's latest inspection by kind of device, earlier ones for features it left out."""
        found: dict[SeenBy, Inspection] = {}
        for inspection in (kept.value for kept in self.inspections):
            by = self.seen_by(inspection) if inspection.part.identity == part.identity else None
            if by is not None:
                found[by] = _completed(inspection, found[by]) if by in found else inspection
        return found

    def kept_at(self, part: Part) -> int:
        """Returns the place of its first inspection among those kept."""
        return next(k for k, kept in enumerate(self.inspections) if kept.value.part.identity == part.identity)


def _completed(latest: Inspection, earlier: Inspection) -> Inspection:
    """Returns an inspection with the values of an earlier one, measured alike, on features that it did not measure."""
    measured = {_place_of(value) for value in latest.values}
    missed = tuple(value for value in earlier.values if (at := _place_of(value)) and at not in measured)
    if not missed or "" in measured or latest.measured != earlier.measured:
        return latest
    return replace(latest, values=(*latest.values, *missed), count=len(latest.values) + len(missed))


def _place_of(value: Touch | Reading | CmmPoint) -> str:
    """Returns the feature of a value, or the characteristic of a reading; "" where neither is known."""
    if isinstance(value, CmmPoint):
        return ""
    return value.feature or (value.characteristic if isinstance(value, Reading) else "")


def tool_of(cut: Cut) -> str:
    """Returns the name of the tool that cut, by its number where it has none; "" where nothing is stated."""
    if cut.setting is None:
        return ""
    tool = cut.setting.edge.tool
    return tool.name or f"T{tool.number}"


def read_records(store: Store, part_type: str | None) -> Records:
    """Reads that part type, or the only one. Raises DIA-NONE where the store holds none of it, or several."""
    (name,) = types_of(store, part_type)[:1]
    cuts = [stored.value for stored in find(store, Cut, part_type=name)]
    standards = [stored.value for stored in find(store, StandardPart, part_type=name)]
    inspections = tuple(stored for stored in find(store, Inspection, part_type=name) if stored.value.values)
    return Records(
        part_type=name,
        inspections=inspections,
        links={stored.value.inspection: stored.value for stored in find(store, InspectionLink)},
        cuts={cut.part.identity: cut for cut in cuts if cut.stage is Stage.FINISH},
        early=frozenset(cut.identity for cut in cuts if cut.stage is not Stage.FINISH),
        quarantined=quarantined_cuts(store) if cuts else frozenset(),
        both=tuple(stored.value for stored in find(store, BothInspections, part_type=name)),
        standards={standard.part.identity: standard for standard in standards},
        corrections={stored.value.record.id: stored.value for stored in find(store, Correction, part_type=name)},
    )


def part_named(store: Store, serial: str, part_type: str | None) -> WholePart:
    """Returns the part of that serial number with its cuts. Raises DIA-NONE: none, with similar names, or several."""
    same = {stored.value.identity: stored.value for stored in find(store, Part, serial=serial)}
    found = [share for share in joined_shares(same.values()) if part_type in (None, share.part.part_type.name)]
    found = found or [WholePart(part, (part,)) for part in same.values() if part.part_type.name == part_type]
    if len(found) == 1:
        return found[0]
    if found:
        names = ", ".join(sorted({whole_part.part.part_type.name for whole_part in found}))
        raise Code.DIA_NONE.refusal(
            f"{len(found)} parts have the serial number {serial!r}",
            hint=f"say of which part type: `--type NAME`, one of {names}",
        )
    known = sorted(
        {stored.value.serial for stored in find(store, Part) if part_type in (None, stored.value.part_type.name)}
    )
    raise Code.DIA_NONE.refusal(
        f"the store holds no part {serial!r}; it holds {len(known)}", hint=_instead(serial, known)
    )


def types_of(store: Store, part_type: str | None) -> tuple[str, ...]:
    """Returns the part type of that name, the only one, or those of its shares. Raises DIA-NONE: none, or several."""
    known = list(dict.fromkeys(_types(store)))
    if part_type in known or (part_type is None and len(known) == 1):
        return (part_type or known[0],)
    shares = known if part_type is None else [one for one in known if one.startswith(f"{part_type}, ")]
    if (whole := whole_of(shares)) is not None and part_type in (None, whole):
        return tuple(shares)
    if part_type is None and known:
        message, hint = f"the store holds inspections of {len(known)} part types", "say which: `--type NAME`; "
        raise Code.DIA_NONE.refusal(message, hint=hint + ", ".join(known))
    raise Code.DIA_NONE.refusal(
        "the store holds 0 inspections" + ("" if part_type is None else f" of part type {part_type!r}"),
        hint=_instead(part_type or "", known),
    )


def _types(store: Store) -> Iterator[str]:
    yield from (stored.value.part.part_type.name for stored in find(store, Inspection))


def _instead(name: str, names: Sequence[str]) -> str:
    if not names:
        return "`trueloop series add` and `trueloop compensate --db` keep inspections"
    return did_you_mean(name, names) or f"known are {', '.join(names[:10])}"


def quarantined_cuts(store: Store) -> frozenset[Identity]:
    """Cuts in quarantine: of each the latest word counts."""
    words = sorted((stored.value for stored in find(store, Quarantine)), key=lambda quarantine: quarantine.at)
    latest = {word.cut: word.lifted for word in words}
    return frozenset(cut for cut, lifted in latest.items() if not lifted)


def quarantined_parts(store: Store) -> frozenset[Identity]:
    """Returns the parts of the cuts in quarantine: a cut's identity begins with its part's."""
    return frozenset(cut[:3] for cut in quarantined_cuts(store))


STANDARD_C = 20.0
WITHIN_K = 2.0
"""ISO 1: sizes hold at 20 °C; further away a calibration needs the part's expansion, which is not known here."""


def keep_standard(
    store: Store, path: Path, part: Part, stated: StatedFacts, by: str = "", *, supersede: bool = False
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
    if not values:
        raise _refused(path, "it holds 0 sizes", "a calibration states sizes: diameters, lengths, each with its name")
    without = [value.characteristic for value in values if not value.standard_u]
    if without:
        listed = ", ".join(without[:5])
        hint = "add the standard uncertainty that the certificate states, of each size"
        raise _refused(path, f"{len(without)} of {len(values)} sizes have no uncertainty: {listed}", hint)
    stated_c = [value.temperature_c for value in values if value.temperature_c is not None]
    if isinstance(one.temperatures, dict):
        stated_c += [float(value) for value in one.temperatures.values()]
    temperature = STANDARD_C if not stated_c else sum(stated_c) / len(stated_c)
    if abs(temperature - STANDARD_C) > WITHIN_K:
        at_20 = "calibrate at 20 ± 2 °C, the temperature at which sizes hold (ISO 1)"
        raise _refused(path, f"it was measured at {temperature:.1f} °C", at_20)
    at: datetime | None = one.measured_at
    kept = StandardPart(part, values, at, by or one.operator, temperature)
    return keep_facts(store, (part, kept), _coarse(values), supersede=supersede)


def standard_of(part_type: str, serial: str) -> Part:
    """Makes a part from its names."""
    return Part(PartType(part_type), serial)


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


DECOMPOSE = "`trueloop machine decompose --serial` keeps both inspections of a part"


@dataclass(frozen=True, eq=False)
class GivenModel:
    """A model with the file and its hash."""

    path: Path
    model: MachineModel
    sha256: str


def given_model(path: Path) -> GivenModel:
    """Reads a model file. Raises MCH-FILE."""
    return GivenModel(path, read_model(path, offered=True), sha256_of(path.read_bytes()))


def both_of_machine(
    store: Store, model: GivenModel, part_types: Collection[str] = (), accept: Collection[str] = ()
) -> tuple[list[BothSeen], list[Finding]]:
    """Returns all parts of the model's machine, in the order in which they were kept; without those in quarantine.

    Raises DIA-NONE where there is none, DIA-PART for a part of a machine of that name with another serial number, which
    `accept` leaves out. A note DIA-MODEL names which parts were cut under another model.
    """
    machine = model.model.machine
    kept = [one.value for one in find(store, BothInspections, machine=machine.name)]
    of_type = [pair for pair in kept if not part_types or pair.part.part_type.name in part_types]
    if not of_type:
        stored = [one.value for one in find(store, BothInspections)]
        machines = sorted({pair.machine.name for pair in stored})
        types = sorted({pair.part.part_type.name for pair in stored if pair.machine.name == machine.name})
        asked, known = (machine.name, machines) if machine.name not in machines else (next(iter(part_types), ""), types)
        of = f" of part type {asked!r}" if machine.name in machines else ""
        raise Code.DIA_NONE.refusal(
            f"the store holds 0 parts{of} that machine {machine.name!r} and a measuring machine inspected",
            hint=did_you_mean(asked, known) or f"known are {', '.join(known) or 'none'}; {DECOMPOSE}",
        )
    findings: list[Finding] = []
    own = [pair for pair in of_type if not machine.serial or pair.machine.serial in ("", machine.serial)]
    for pair in of_type:
        if pair not in own:
            findings.append(_accepted(_other_machine(pair, machine.serial), accept))
    out = quarantined_parts(store)
    serials = [pair.part.serial for pair in own if pair.part.identity in out]
    if serials:
        message = f"{len(serials)} parts are in quarantine and left out: {', '.join(serials[:5])}"
        hint = "`trueloop db show` says why"
        findings.append(
            Finding(Severity.NOTE, Code.DIA_FEW, message, hint, values={"count": len(own) - len(serials), "needed": 2})
        )
    own = [pair for pair in own if pair.part.identity not in out]
    findings += cut_under_others(own, model.sha256)
    inspections = {one.value.identity: one.value for one in find(store, Inspection)} if own else {}
    return [both_seen(pair, inspections, model.model) for pair in own], findings


def both_seen(pair: BothInspections, inspections: Mapping[Identity, Inspection], model: MachineModel) -> BothSeen:
    """Converts both inspections for a diagnosis. Raises DIA-PART where they are not of the same points of that part."""
    on_machine, on_cmm = (inspections.get(identity) for identity in (pair.on_machine, pair.on_cmm))
    if on_machine is None or on_cmm is None:
        raise _not_alike(pair, "one of its two inspections is not in the store, or was superseded")
    if {on_machine.part.identity, on_cmm.part.identity} != {pair.part.identity}:
        raise _not_alike(pair, "its two inspections are kept as of other parts")
    nominal, normal, controller = _arrays(on_machine)
    other_nominal, _, cmm = _arrays(on_cmm)
    if nominal.shape != other_nominal.shape or not np.allclose(nominal, other_nominal, atol=1e-6):
        raise _not_alike(pair, f"{len(nominal)} and {len(other_nominal)} points are not the same gauging points")
    comp_proc_mm = np.array(pair.comp_proc_mm) if pair.comp_proc_mm else 0.0
    seen = Inspections(
        nominal_mm=nominal,
        normal=normal,
        controller_mm=controller,
        cmm_mm=cmm,
        touch_u_mm=pair.touch_u_mm,
        cmm_u_mm=pair.cmm_u_mm,
        comp_proc_mm=comp_proc_mm,
    )
    names = tuple(point.name for point in on_machine.points)
    cutting, probing = (_state(model, seen, stood) for stood in (pair.cutting, pair.probing))
    kind = pair.part.part_type.name
    return BothSeen(
        serial=pair.part.serial,
        part_type=kind,
        points=names,
        seen=seen,
        cutting=cutting,
        probing=probing,
        compensated=pair.compensated,
        new_frame=pair.new_frame,
    )


def _state(model: MachineModel, inspections: Inspections, stood: MachineStood) -> State:
    tools = stood.tools_mm[0] if len(stood.tools_mm) == 1 else np.array(stood.tools_mm)
    return states_of(model, inspections, stood.work_zero_mm, tools, stood.signals)


def _arrays(of: Inspection) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    points: tuple[CmmPoint, ...] = of.points
    columns = ([p.nominal_mm for p in points], [p.outward_normal for p in points], [p.measured_mm for p in points])
    nominal, normal, measured = (np.array(rows, dtype=np.float64).reshape(-1, 3) for rows in columns)
    return nominal, normal, measured


def _accepted(refusal: TrueloopError, accept: Collection[str]) -> Finding:
    if refusal.code not in accept:
        raise refusal
    return Finding(Severity.WARNING, refusal.code, refusal.message, refusal.hint, values=refusal.values)


def _other_machine(pair: BothInspections, serial: str) -> TrueloopError:
    return Code.DIA_PART.refusal(
        f"part {pair.part.serial!r} was cut on {pair.machine.name!r} with serial number {pair.machine.serial!r}, the "
        f"model is of {serial!r}",
        hint="every machine errs in its own way: name the model of that machine",
        override="--accept DIA-PART",
        values={"part": pair.part.serial},
    )


def _not_alike(pair: BothInspections, why: str) -> TrueloopError:
    return Code.DIA_PART.refusal(
        f"part {pair.part.serial!r}: {why}",
        hint="decompose it again: `trueloop machine decompose --serial … --supersede`",
        values={"part": pair.part.serial},
    )


def cut_under_others(own: Collection[BothInspections], sha256: str) -> Iterator[Finding]:
    """Yields DIA-MODEL as a note: parts that were cut under another model than the one of that hash."""
    others = [pair for pair in own if pair.compensated and pair.model_sha256 != sha256]
    if others:
        serials = [pair.part.serial for pair in others]
        yield Finding(
            Severity.NOTE,
            Code.DIA_MODEL,
            f"{len(others)} of {len(own)} parts were cut under another model: {', '.join(serials[:5])}",
            "what this model would have left is worked out from what the control reported; it holds if the control did "
            "not correct its own readings",
            values={"part": serials[0]},
        )
