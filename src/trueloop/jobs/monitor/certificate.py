"""The certificate of a part from the store, and its files."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import BothInspections, Inspection, Reading, Values
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.domain.option import Language, LengthUnit
from trueloop.domain.part import Part, WholePart, joined_shares
from trueloop.domain.proposal import ModelDecision, PartCutWith, Proposal, ProposalDecision
from trueloop.domain.record import Correction, ProgramText
from trueloop.errors import Code
from trueloop.geometry.profile import Profile
from trueloop.jobs.turned.shares import of_characteristic
from trueloop.jobs.user import user_name
from trueloop.loops.monitor.certificate import Certificate, InForce, PartInspection, RequiredSize, asked_of, certified
from trueloop.loops.turned import correction as turned
from trueloop.loops.turned.correction import Correction as TurnedCorrection
from trueloop.loops.turned.in_force import cut_with
from trueloop.loops.turned.made_parts import program_that_ran
from trueloop.loops.turned.share import characteristics_in, frame_of
from trueloop.report.markup import write_page
from trueloop.report.monitor.certificate import CertificateShape, certificate_page, certificate_shape
from trueloop.storage.store import Store, find
from trueloop.turned.characteristics.measurand import SAME, place_of, usual
from trueloop.turned.program.wear_numbers import known_to
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import MatchedReading
from trueloop.turned.readings.sizes import axial_mm
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording


def certify_part(
    store: Store, serial: str, part_type: str | None = None, stated_u_um: float | None = None, who: str = ""
) -> CertificateShape:
    """Makes the certificate of a part. `stated_u_um`: standard uncertainty of readings that state none.

    Of a part that several edges or set-ups cut the certificate is of the whole. Raises MON-NONE for a part that the
    store does not know, of which it knows several, or that was not measured.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> trueloop.certify_part(store, "101", stated_u_um=1.0, who="K. Roth").outcome
    'does not conform'
    """
    whole = _part(store, serial, part_type)
    shares = [_share(store, part) for part in whole.shares]
    u = None if stated_u_um is None else stated_u_um / UM_PER_MM
    asked = {size.name: size for share in shares for size in share.asked}
    values = certified(
        whole.part, tuple(asked.values()), [inspection for share in shares for inspection in share.seen], u
    )
    in_force = {(one.what, one.identity): one for share in shares for one in share.in_force}
    missing = dict.fromkeys(words for share in shares for words in share.missing)
    done = Certificate(whole.part, values, tuple(in_force.values()), tuple(missing), _cut_at(shares))
    return certificate_shape(done, datetime.now(UTC), who or user_name(), stated_u_um)


@dataclass(frozen=True)
class _Share:
    """The store's values of one edge's cut of a part, or of a part that is kept whole."""

    cut: Cut | None
    asked: tuple[RequiredSize, ...]
    seen: tuple[PartInspection, ...]
    in_force: tuple[InForce, ...]
    missing: tuple[str, ...]


def _share(store: Store, part: Part) -> _Share:
    cuts = [stored.value for stored in find(store, Cut, part_type=part.part_type.name, serial=part.serial)]
    cut = next(
        (one for one in reversed(cuts) if one.stage is Stage.FINISH and one.part.identity == part.identity), None
    )
    of_type = [stored.value for stored in find(store, Inspection, part_type=part.part_type.name)]
    of_type = [inspection for inspection in of_type if inspection.part.part_type.identity == part.part_type.identity]
    seen = tuple(
        _seen(store, [inspection for inspection in of_type if inspection.part.identity == part.identity], cuts, cut)
    )
    in_force, missing = _in_force(store, part, cut, [inspection.inspection for inspection in seen])
    drawing = drawing_of(store, part)
    if drawing is None:
        return _Share(cut, asked_of(of_type), seen, in_force, missing)
    in_its_names = [drawing.in_its_names(inspection) for inspection in of_type]
    asked = {size.name: size for size in (*asked_of(in_its_names), *drawing.required(in_its_names))}
    seen = tuple(replace(inspection, inspection=drawing.in_its_names(inspection.inspection)) for inspection in seen)
    return _Share(cut, tuple(asked.values()), seen, in_force, missing)


def _cut_at(shares: Sequence[_Share]) -> datetime | None:
    """When the last of the cuts was done; None where that is not known of all."""
    times = [None if share.cut is None else share.cut.at for share in shares]
    known = [at for at in times if at is not None]
    return max(known) if len(known) == len(times) else None


def _part(store: Store, serial: str, part_type: str | None) -> WholePart:
    found = {stored.value.identity: stored.value for stored in find(store, Part, serial=serial)}
    every = joined_shares(found.values())
    parts = [whole_part for whole_part in every if part_type in (None, whole_part.part.part_type.name)]
    parts = parts or [WholePart(part, (part,)) for part in found.values() if part.part_type.name == part_type]
    if len(parts) == 1:
        return parts[0]
    types = ", ".join(repr(part.part.part_type.name) for part in parts) or "none"
    raise Code.MON_NONE.refusal(
        f"the store holds {len(parts)} parts with the serial number {serial!r}, of part types: {types}",
        hint="say which: `--type NAME`; `trueloop db find part` lists all",
        values={"characteristic": serial},
    )


def _seen(
    store: Store, inspections: Sequence[Inspection], cuts: Sequence[Cut], last: Cut | None
) -> Iterator[PartInspection]:
    """Inspections of the part, without those after a cut before the `last` finish cut."""
    links = {stored.value.inspection: stored.value for stored in find(store, InspectionLink)}
    early = {cut.identity for cut in cuts if last is None or cut.identity != last.identity}
    for inspection in inspections:
        link = links.get(inspection.identity)
        if link is None or link.cut not in early:
            yield PartInspection(inspection, None if link is None else link.released)


def _in_force(
    store: Store, part: Part, cut: Cut | None, inspections: Sequence[Inspection]
) -> tuple[tuple[InForce, ...], tuple[str, ...]]:
    """The correction in force when the part was cut, and what is unknown about it."""
    found, missing = list[InForce](), list[str]()
    if cut is None:
        missing.append(wording("no finish cut is kept: program, tool and correction are not known"))
    else:
        found += _of_cut(store, cut)
        if not cut.program_sha256:
            missing.append(wording("the program that ran is not known"))
        if cut.setting is None:
            missing.append(wording("the edge that cut is not known"))
        elif cut.setting.set_at is None:
            missing.append(wording("when the tool was set is not known"))
        if cut.correction and not _corrections(store, cut):
            missing.append(wording("correction {id} is not in the store", id=cut.correction))
    both = [stored.value for stored in find(store, BothInspections, part_type=part.part_type.name, serial=part.serial)]
    for model in dict.fromkeys(pair.model_sha256 for pair in both if pair.compensated):
        found.append(_model(store, model))
    if not any(in_force.what == "model" for in_force in found):
        missing.append(wording("no machine model is known to have been in force"))
    found += _proposals(store, inspections)
    return tuple({(in_force.what, in_force.identity): in_force for in_force in found}.values()), tuple(missing)


def _of_cut(store: Store, cut: Cut) -> Iterator[InForce]:
    if cut.machine is not None:
        named = " ".join(filter(None, (cut.machine.name, cut.machine.serial)))
        yield InForce(wording("machine"), named, "")
    if cut.program_sha256:
        kept = bool(find(store, ProgramText, program_sha256=cut.program_sha256))
        yield InForce(
            wording("program"),
            cut.program_sha256,
            wording("its text is kept") if kept else wording("its text is not kept"),
        )
    if cut.setting is not None:
        at = "" if cut.setting.set_at is None else wording("set at {at}", at=_time(cut.setting.set_at))
        yield InForce(wording("edge"), " ".join(filter(None, cut.setting.edge.identity)), at)
    if not cut.correction and cut.program_sha256:
        yield InForce(wording("correction"), "", wording("none: cut as programmed"))
    for correction in _corrections(store, cut):
        said = wording("made {at} by {who}", at=correction.record.made_at, who=correction.record.made_by or "?")
        yield InForce(wording("correction"), correction.record.id, said)
        machine = correction.record.options.get("machine")
        model = machine.get("model") if isinstance(machine, Mapping) else None
        for name, sha256 in correction.record.inputs_sha256.items():
            if name == "model" or sha256 == model:
                yield _model(store, sha256)
            else:
                yield InForce(wording("input of the correction"), sha256, name)
        yield from _offset_in_force(correction, cut)


def _corrections(store: Store, cut: Cut) -> list[Correction[Any]]:
    if not cut.correction:
        return []
    return [stored.value for stored in find(store, Correction, identity=cut.correction)]


def _offset_in_force(correction: Correction[Any], cut: Cut) -> Iterator[InForce]:
    """The tool offset by which the tool stood off the path of the program that ran; nothing where none was in force."""
    record = correction.record
    if not isinstance(correction.payload, turned.Correction) or record.tool_offset is None:
        return
    force = cut_with(record, program_that_ran(correction.payload, cut))
    if force.offset_mm != (0.0, 0.0):
        x_mm, z_mm = force.offset_mm
        words: str = wording(
            "tool {tool}: X {x} on the radius, {diameter} on the diameter, Z {z}",
            tool=record.tool_offset.tool,
            x=Um(x_mm, "+.1f"),
            diameter=Um(2 * x_mm, "+.1f"),
            z=Um(z_mm, "+.1f"),
        )
        if (known := record.tool_offset.expanded_u_mm) is not None:
            words = known_to(words, *(None if u_mm is None else Um(u_mm) for u_mm in known))
        yield InForce(wording("tool offset"), record.id, words)


def _model(store: Store, sha256: str) -> InForce:
    """A machine's model by its hash, and who accepted it, where that was kept."""
    decided = [stored.value for stored in find(store, ModelDecision) if stored.value.model == sha256]
    words = "" if not decided else wording(
        "{verdict} by {who} at {at}", verdict=decided[-1].verdict, who=decided[-1].who, at=_time(decided[-1].at)
    )  # fmt: skip
    return InForce(wording("model"), sha256, words)


def _proposals(store: Store, inspections: Sequence[Inspection]) -> Iterator[InForce]:
    """Offsets of accepted proposals, as they were stated when the inspection was added."""
    own = {inspection.identity for inspection in inspections}
    stated = [stored.value for stored in find(store, PartCutWith) if stored.value.inspection in own]
    wanted = dict.fromkeys(name for one in stated for name in one.proposals)
    known = {stored.value.id: stored.value for stored in find(store, Proposal)} if wanted else {}
    decided = {stored.value.proposal: stored.value for stored in find(store, ProposalDecision)} if wanted else {}
    for name in wanted:
        if name in known and name in decided:
            changes = ", ".join(
                f"{effect.characteristic} {Um(effect.size_change_mm, '+.1f')}" for effect in known[name].effects
            )
            yield InForce(
                wording("proposal"), name,
                wording("{changes}; accepted by {who} at {at}", changes=changes, who=decided[name].who,
                        at=_time(decided[name].at)),
            )  # fmt: skip


def _time(at: datetime) -> str:
    return f"{at:%Y-%m-%d %H:%M}"


def write_certificate(shown: CertificateShape, folder: Path, language: Language, unit: LengthUnit) -> list[str]:
    """Writes certificate-SERIAL.json and .html to a folder, both or none. Raises OUT errors."""
    name = "certificate-" + "".join(one if one.isalnum() or one in "-_." else "_" for one in shown.serial)
    return write_page(shown, name, certificate_page, folder, language, unit)


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
    for kept in reversed(find(store, Correction, part_type=part.part_type.name)):
        record, correction = kept.value.record, kept.value.payload
        if record.part_type is None or record.part_type.identity != part.part_type.identity:
            continue
        if not isinstance(correction, TurnedCorrection) or not (record.characteristics or record.between):
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
