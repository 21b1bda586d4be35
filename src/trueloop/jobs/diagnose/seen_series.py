"""The parts of a type as a diagnosis of causes takes them, recomputed from records of a store.

Diagnoses of parts and series from a store, as shapes.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeVar

import numpy as np

from trueloop.diagnosis.causes.cause import SeenBy, SeenPart
from trueloop.diagnosis.features.feature_error import ErrorKind, FeaturePlace
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection
from trueloop.domain.life import Cut, EdgeEvent, Identity, Ran
from trueloop.domain.part import Part
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.factory.book import read_book
from trueloop.geometry.profile import Profile
from trueloop.jobs.diagnose.records import (
    GivenModel,
    Records,
    both_seen,
    given_model,
    part_named,
    read_records,
    tool_of,
    types_of,
)
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.shares import shares_of
from trueloop.loops.diagnosis.part import InspectedPart, diagnose_part, diagnose_series
from trueloop.loops.diagnosis.points_of import places_of
from trueloop.loops.post_process.series import SeriesOptions, When, identity_of, parts_in_order, sizes_of
from trueloop.loops.turned import correction as turned
from trueloop.loops.turned.made_parts import program_that_ran
from trueloop.report.diagnosis.shapes import PartDiagnosisShape, SeriesDiagnosisShape
from trueloop.report.diagnosis.values import part_shape, series_shape
from trueloop.storage.store import Store, find

KINDS = {
    Quantity.DIAMETER: (ErrorKind.RADIUS, 0.5),
    Quantity.RADIUS: (ErrorKind.RADIUS, 1.0),
    Quantity.LENGTH: (ErrorKind.LENGTH, 1.0),
}
"""Which error of a feature a size is, and how much of the size it is."""


def proposals_in_force(store: Store, records: Records) -> Mapping[Identity, Mapping[Identity, float]]:
    """Returns by part how much accepted proposals took off each series of sizes."""
    sized = any(any(sizes_of(inspection.value)) for inspection in records.inspections)
    parts = read_book(store, records.part_type, SeriesOptions()).parts if sized else ()
    return {part.inspection.part.identity: part.correction_mm for part in parts}


def of_proposals(
    by_series: Mapping[Identity, float], inspections: Collection[Inspection]
) -> dict[tuple[str, str], float]:
    """Returns what was taken off readings by feature and kind of error, of a diameter twice; 0 is as missing."""
    taken: dict[tuple[str, str], float] = {}
    done: set[Identity] = set()
    for inspection in inspections:
        for asked, _ in sizes_of(inspection):
            series = identity_of(inspection.part.part_type, asked)
            if series in by_series and series not in done and asked.quantity in KINDS:
                done.add(series)
                kind, share = KINDS[asked.quantity]
                key = (asked.feature or asked.name, str(kind))
                taken[key] = taken.get(key, 0.0) + share * by_series[series]
    return taken


def _carried_out(records: Records, cut: Cut | None) -> tuple[turned.Correction, Ran] | None:
    """Returns the correction that a cut was made with, and by which of its ways. Raises STO-PROGRAM."""
    kept = None if cut is None else records.corrections.get(cut.correction)
    if cut is None or kept is None or not isinstance(kept.payload, turned.Correction):
        return None
    return kept.payload, program_that_ran(kept.payload, cut)


def _made_from(records: Records, inspection: Inspection) -> turned.Correction | None:
    """Returns the latest correction that was made from an inspection."""
    made = [one.payload for one in records.corrections.values() if inspection in one.record.inspections]
    return next((one for one in reversed(made) if isinstance(one, turned.Correction)), None)


@dataclass(frozen=True, eq=False)
class Sources:
    """Where a series is read from: `places` of features, a `model` of the machine for what its probe reported."""

    store: Store
    records: Records
    places: Mapping[str, FeaturePlace]
    model: GivenModel | None = None
    accept: Collection[str] = ()


def parts_of(of: Sources, serials: Collection[str] = ()) -> tuple[list[InspectedPart], list[Finding]]:
    """Parts in cutting order with all that is known of each. With `serials` only these, with their place in the order.

    Raises DIA-CLOCK for times of a part that contradict each other, unless it is accepted.
    """
    records, parts = of.records, of.records.parts
    order, doubts = parts_in_order([_when(records, part) for part in parts])
    findings = list(doubts)
    settings = _Settings(of.store, list(records.cuts.values()))
    proposals = proposals_in_force(of.store, records)
    found = []
    for number, part in enumerate(parts[k] for k in order):
        findings += _clocks(records, part, of.accept)
        found.append(_inspected(of, part, number, settings, proposals.get(part.identity, {})))
    if records.out:
        left = ", ".join(sorted(identity[-1] for identity in records.out)[:5])
        message = f"{len(records.out)} parts are in quarantine and left out: {left}"
        values = {"count": len(parts), "needed": 2}
        findings.append(Finding(Severity.NOTE, Code.DIA_FEW, message, "`trueloop db show` says why", values=values))
    return [one for one in found if not serials or one.part.serial in serials], findings


def _inspected(
    of: Sources, part: Part, number: int, settings: "_Settings", proposals: Mapping[Identity, float]
) -> InspectedPart:
    records = of.records
    cut, seen = records.cuts.get(part.identity), dict(records.of_part(part))
    both = next((pair for pair in reversed(records.both) if pair.part.identity == part.identity), None)
    taken = None
    if both is not None and of.model is not None:
        inspections = {kept.value.identity: kept.value for kept in records.inspections}
        taken = both_seen(both, inspections, of.model.model)
        if SeenBy.MACHINE in seen and seen[SeenBy.MACHINE].identity == both.on_machine:
            process_mm = taken.components(of.model.model)[0].error_proc_resid
            # The probe's errors less the model's error at probing: those of the process [6876 §3.3]
            one = seen[SeenBy.MACHINE]
            values = tuple(_displaced(point, e) for point, e in zip(one.points, process_mm.tolist(), strict=True))
            seen[SeenBy.MACHINE] = replace(one, values=values)
    temperatures = both.cutting.signals if both is not None else _temperatures(seen.values())
    tool = "" if cut is None else tool_of(cut)
    depth = None if cut is None else cut.conditions.depth_of_cut_mm
    own = [name for name, place in of.places.items() if place.tool in ("", tool)]
    at = cut.at if cut is not None and cut.at is not None else next((o.measured_at for o in seen.values()), None)
    made = SeenPart(
        serial=part.serial,
        order=number,
        errors={},
        points={},
        at=at,
        setting={tool: settings.count(cut)} if cut is not None and tool else {},
        minutes_in_cut=settings.minutes(cut, tool),
        depth_of_cut_mm={} if depth is None else dict.fromkeys(own, depth),
        temperatures=dict(temperatures),
        correction_mm=of_proposals(proposals, seen.values()),
        standard=part.identity in records.standards,
    )
    return InspectedPart(
        part=part,
        made=made,
        seen=seen,
        standard=records.standards.get(part.identity),
        both=taken,
        cut_with=_carried_out(records, cut),
        corrected={by: kept for by, one in seen.items() if (kept := _made_from(records, one)) is not None},
    )


def _displaced(point: CmmPoint, error_mm: float) -> CmmPoint:
    """Measured that far outside its nominal place."""
    if point.nominal_mm is None or point.outward_normal is None:
        return point
    (x, y, z), (a, b, c) = point.nominal_mm, point.outward_normal
    return replace(point, measured_mm=(x + error_mm * a, y + error_mm * b, z + error_mm * c))


def _when(records: Records, part: Part) -> When:
    cut, seen = records.cuts.get(part.identity), records.of_part(part)
    measured = next(
        (inspection.measured_at for inspection in seen.values() if inspection.measured_at is not None), None
    )
    if cut is None:
        return When(part.serial, records.kept_at(part), measured_at=measured)
    return When(
        serial=part.serial,
        kept=records.kept_at(part),
        cut_order=cut.order,
        cut_at=cut.at,
        measured_at=measured,
        in_doubt=cut.order_in_doubt,
    )


def _temperatures(inspections: Collection[Inspection]) -> Mapping[str, float]:
    """Those of an inspection on the machine, else of any."""
    return next((inspection.temperatures for inspection in inspections if inspection.temperatures), {})


def _clocks(records: Records, part: Part, accept: Collection[str]) -> list[Finding]:
    """Parts measured before they were cut, or cut before their tool was set."""
    cut = records.cuts.get(part.identity)
    if cut is None or cut.at is None:
        return []
    pairs: list[tuple[str, datetime | None, str, datetime | None]] = [
        ("its inspection", inspection.measured_at, "its cut", cut.at) for inspection in records.of_part(part).values()
    ]
    if cut.setting is not None:
        pairs.append(("its cut", cut.at, "the setting of its tool", cut.setting.set_at))
    for later, second, earlier, first in pairs:
        if second is not None and first is not None and _utc(second) < _utc(first):
            said = (
                f"part {part.serial!r}: {later} at {_utc(second):%Y-%m-%d %H:%M} UTC is before {earlier} at "
                f"{_utc(first):%Y-%m-%d %H:%M} UTC"
            )
            hint = (
                "one clock is wrong: set it, and keep the right times; settings and temperatures may be another part's"
            )
            values = {"part": part.serial}
            if Code.DIA_CLOCK not in accept:
                raise Code.DIA_CLOCK.refusal(said, hint=hint, override="--accept DIA-CLOCK", values=values)
            return [Finding(Severity.WARNING, Code.DIA_CLOCK, said, hint, values=values)]
    return []


def _utc(at: datetime) -> datetime:
    return at if at.tzinfo is None else at.astimezone(UTC).replace(tzinfo=None)


class _Settings:
    """Settings of each edge counted over the cuts, and how long each had cut."""

    def __init__(self, store: Store, cuts: Sequence[Cut]) -> None:
        self.cuts = [cut for cut in cuts if cut.setting is not None]
        self.events = [stored.value for stored in find(store, EdgeEvent)] if self.cuts else []

    def count(self, cut: Cut) -> int:
        """Returns which setting of its tool it was cut with, from 1."""
        times = {_set_at(one) for one in self.cuts if tool_of(one) == tool_of(cut)}
        return sorted(times).index(_set_at(cut)) + 1

    def minutes(self, cut: Cut | None, tool: str) -> dict[str, float]:
        """Returns how long the edge had cut when this cut was done; empty where one of its cuts has no time."""
        if cut is None or cut.setting is None:
            return {}
        key = _place(cut)
        before = [one for one in self.cuts if _same_edge(one, cut) and _place(one) <= key]
        stated = [
            event
            for event in self.events
            if event.edge.identity == cut.setting.edge.identity
            and "minutes_in_cut" in event.values
            and cut.at is not None
            and event.at <= cut.at
        ]
        base = max(stated, key=lambda event: event.at) if stated else None
        since = [one for one in before if base is None or (one.at is not None and one.at > base.at)]
        spent = [one.conditions.time_in_cut_min for one in since]
        if any(minutes is None for minutes in spent) or (base is None and not spent):
            return {}
        return {tool: (base.values["minutes_in_cut"] if base else 0.0) + float(np.sum([m or 0.0 for m in spent]))}


def _set_at(cut: Cut) -> float:
    """Seconds; a setting whose time is not stated comes first."""
    at = None if cut.setting is None else cut.setting.set_at
    return 0.0 if at is None else at.timestamp()


def _same_edge(cut: Cut, other: Cut) -> bool:
    a, b = cut.setting, other.setting
    return a is not None and b is not None and a.edge.identity == b.edge.identity


def _place(cut: Cut) -> tuple[float, float]:
    return (float(cut.order or 0), cut.at.timestamp() if cut.at is not None else 0.0)


@dataclass(frozen=True)
class DiagnosisOptions:
    """Options of a diagnosis: part type, job that gives the profile, model; `accept` are codes."""

    part_type: str | None = None
    job: Path | None = None
    model: Path | None = None
    accept: tuple[str, ...] = ()


def sources_of(store: Store, options: DiagnosisOptions, part_type: str | None) -> Sources:
    """Collects the records of a part type, where its features lie, and the model. Raises DIA-NONE."""
    records = read_records(store, part_type)
    model = None if options.model is None else given_model(options.model)
    return Sources(store, records, _places(records, options.job), model, options.accept)


def _profile(job: Path, part_type: str) -> Profile:
    """Returns the profile of a job's part, or of what one edge cuts of it, of that type, in its program's frame."""
    files = JobFiles.of(job)
    shares = shares_of(files) if files.job.tools or files.job.setups else []
    return (
        next((share.own.profile for share in shares if share.files.job.part.name == part_type), None) or files.profile()
    )


def _places(records: Records, job: Path | None) -> Mapping[str, FeaturePlace]:
    """Returns the features of the job's profile, of the last correction's, or those that values imply."""
    seen = [kept.value for kept in records.inspections if records.seen_by(kept.value) is not None]
    made = (correction.payload for correction in reversed(tuple(records.corrections.values())))
    corrected = next((one.profile for one in made if isinstance(one, turned.Correction)), None)
    profile = corrected if job is None else _profile(job, records.part_type)
    places, tools = places_of(seen, profile), records.tools
    return {name: replace(place, tool=tools[0]) for name, place in places.items()} if len(tools) == 1 else places


T = TypeVar("T", PartDiagnosisShape, SeriesDiagnosisShape)


def part(store: Store, serial: str, options: DiagnosisOptions) -> PartDiagnosisShape:
    """Diagnoses one part that one edge cut, or what one edge cut of it. Raises DIA errors, those of job and model."""
    return _only(part_causes(store, serial, options))


def part_causes(store: Store, serial: str, options: DiagnosisOptions | None = None) -> list[PartDiagnosisShape]:
    """Diagnoses one part: what each edge cut of it, where several did. Raises DIA and STO errors.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> (causes,) = trueloop.part_causes(store, "102")
    >>> [(error.feature, error.value_um) for error in causes.part.errors["CMM"]]  # of the radius
    [('journal-24', 14.5), ('seat-30', 13.5), ('seat-36', 15.5)]
    """
    asked = options or DiagnosisOptions()
    return [_part(store, share, asked) for share in part_named(store, serial, asked.part_type).shares]


def _part(store: Store, named: Part, options: DiagnosisOptions) -> PartDiagnosisShape:
    sources = sources_of(store, options, named.part_type.name)
    parts, findings = parts_of(sources)
    own = next((part for part in parts if part.part.identity == named.identity), None)
    if own is None:
        raise _not_inspected(named.serial, quarantined=named.identity in sources.records.out)
    done = diagnose_part(
        own, parts, sources.places, None if sources.model is None else sources.model.model, options.accept
    )
    return part_shape(
        named.part_type.name,
        done.part,
        done.causes,
        (*findings, *done.findings),
        points=done.points,
        components=done.components,
        frame=done.frame,
    )


def series(store: Store, options: DiagnosisOptions) -> SeriesDiagnosisShape:
    """Diagnoses all parts of a type that one edge cut, or what one edge cut of them."""
    return _only(series_causes(store, options))


def series_causes(store: Store, options: DiagnosisOptions | None = None) -> list[SeriesDiagnosisShape]:
    """Diagnoses all parts of a type: what each edge cut of them, where several did. Raises DIA and STO errors.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> (causes,) = trueloop.series_causes(store)
    >>> causes.causes.candidates[0].name, round(causes.causes.candidates[0].probability, 2)
    ('tool offset set wrongly', 0.42)
    """
    asked = options or DiagnosisOptions()
    return [_series(store, name, asked) for name in types_of(store, asked.part_type)]


def _series(store: Store, part_type: str, options: DiagnosisOptions) -> SeriesDiagnosisShape:
    sources = sources_of(store, options, part_type)
    parts, findings = parts_of(sources)
    done = diagnose_series(parts, sources.places, options.accept)
    return series_shape(sources.records.part_type, done.series, done.causes, (*findings, *done.findings))


def _only(choices: Sequence[T]) -> T:
    if len(choices) == 1:
        return choices[0]
    names = ", ".join(repr(choice.part_type) for choice in choices)
    raise Code.DIA_NONE.refusal(
        f"{len(choices)} edges cut the part, each with a diagnosis of its own: {names}",
        hint="state `part_type`: one of these names",
    )


def _not_inspected(serial: str, *, quarantined: bool) -> TrueloopError:
    why = "is in quarantine" if quarantined else "has no inspection after its finish cut that tells its errors"
    return Code.DIA_NONE.refusal(
        f"part {serial!r} {why}: there is nothing to diagnose", hint="`trueloop db show` says what is kept of it"
    )
