"""Diagnoses of parts, series, fixturings and machines from a store, as shapes."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from trueloop.diagnosis.features.feature_place import FeaturePlace
from trueloop.diagnosis.features.fixturing import fixturing
from trueloop.errors import Code, Finding, TrueloopError, in_file
from trueloop.formats.measurements.repeats_csv import read_repeats
from trueloop.geometry.profile import Profile
from trueloop.jobs.diagnose.both import GivenModel, both_of_machine, given_model
from trueloop.jobs.diagnose.records import Records, part_named, read_records
from trueloop.jobs.diagnose.seen_series import Sources, parts_of
from trueloop.jobs.diagnose.shaped import fixture_shape, machine_shape
from trueloop.jobs.turned.job import read_job
from trueloop.loops.diagnosis.inspected import Repeats, repeats_of, require_stable
from trueloop.loops.diagnosis.machine import MachineDiagnosis, diagnose_machine
from trueloop.loops.diagnosis.part import diagnose_part
from trueloop.loops.diagnosis.points_of import places_of
from trueloop.loops.diagnosis.series import diagnose_series
from trueloop.report.diagnosis.machine_shapes import MachineDiagnosisShape
from trueloop.report.diagnosis.shapes import FixtureDiagnosisShape, PartDiagnosisShape, SeriesDiagnosisShape
from trueloop.report.diagnosis.values import part_shape, series_shape
from trueloop.storage.store import Store
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class Asked:
    """What is asked for: of which part type, with the profile of which job, by which model; `accept` are codes."""

    part_type: str | None = None
    job: Path | None = None
    model: Path | None = None
    accept: tuple[str, ...] = ()


def part(store: Store, serial: str, asked: Asked) -> PartDiagnosisShape:
    """One part. Raises DIA errors, and what job and model are refused with."""
    named = part_named(store, serial, asked.part_type)
    sources = _sources(store, asked, named.part_type.name)
    parts, findings = parts_of(sources)
    own = next((one for one in parts if one.part.identity == named.identity), None)
    if own is None:
        raise _not_inspected(serial, quarantined=named.identity in sources.records.out)
    done = diagnose_part(
        own, parts, sources.places, None if sources.model is None else sources.model.model, asked.accept
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


def series(store: Store, asked: Asked) -> SeriesDiagnosisShape:
    """All parts of a type."""
    sources = _sources(store, asked, asked.part_type)
    parts, findings = parts_of(sources)
    done = diagnose_series(parts, sources.places, asked.accept)
    return series_shape(sources.records.part_type, done.series, done.causes, (*findings, *done.findings))


def machine_of(
    store: Store, given: GivenModel, part_types: Collection[str], element: Mapping[str, str], accept: Collection[str]
) -> tuple[MachineDiagnosis, list[Finding]]:
    """The model's verdict, and what is odd of the parts."""
    parts, findings = both_of_machine(store, given, part_types, accept)
    return diagnose_machine(given.model, parts, element, accept), findings


def machine(
    store: Store, model: Path, part_types: Collection[str], element: Mapping[str, str], accept: Collection[str]
) -> MachineDiagnosisShape:
    """Which axis errors the model of a machine has wrong."""
    given = given_model(model)
    done, findings = machine_of(store, given, part_types, element, accept)
    return machine_shape(given, done, findings)


@dataclass(frozen=True)
class Repeatability:
    """What one reading is expected to repeat to, and what it may vary by; None: as stated, and no limit."""

    standard_u_mm: float | None = None
    limit_mm: float | None = None


def fixture_of_file(path: Path, repeatability: Repeatability, accept: Collection[str] = ()) -> FixtureDiagnosisShape:
    """Repeats in a file. Raises DIA-FEW, and DIA-UNSTABLE unless it is accepted or only shown."""
    read, u_mm = read_repeats(path, repeatability.standard_u_mm)
    with in_file(path):
        found = [Repeats(name, mm, u_mm, fixturing(mm, u_mm, repeatability.limit_mm)) for name, mm in read.items()]
    return _fixture(path.stem, found, accept)


def fixture_of_part(store: Store, serial: str, asked: Asked, repeatability: Repeatability) -> FixtureDiagnosisShape:
    """Repeats of a part's own points and readings. Raises DIA-NONE and DIA-FEW."""
    named = part_named(store, serial, asked.part_type)
    sources = _sources(store, asked, named.part_type.name)
    parts, _ = parts_of(sources, (serial,))
    repeats = [
        one
        for each in parts
        for points in each.points(sources.places).values()
        for one in repeats_of(points, repeatability.standard_u_mm, repeatability.limit_mm)
    ]
    if not repeats:
        raise TrueloopError(
            Code.DIA_FEW,
            f"no point of part {serial!r} was read 5 times: its fixturing cannot be judged",
            hint="touch one point repeatedly right after fixturing, and keep the readings",
            values={"count": 0, "needed": 5},
        )
    return _fixture(serial, repeats, asked.accept)


def _fixture(name: str, repeats: Sequence[Repeats], accept: Collection[str]) -> FixtureDiagnosisShape:
    """What is unstable is shown here, and refused elsewhere."""
    findings = require_stable([("", one) for one in repeats], (*accept, Code.DIA_UNSTABLE))
    return fixture_shape(name, repeats, findings)


def _sources(store: Store, asked: Asked, part_type: str | None) -> Sources:
    records = read_records(store, part_type)
    model = None if asked.model is None else given_model(asked.model)
    return Sources(store, records, _places(records, asked.job), model, asked.accept)


def _places(records: Records, job: Path | None) -> Mapping[str, FeaturePlace]:
    profile: Profile | None = None if job is None else read_job(job).inputs.profile
    seen = [kept.value for kept in records.inspections if records.seen_by(kept.value) is not None]
    places, tools = places_of(seen, profile), records.tools
    return {name: replace(place, tool=tools[0]) for name, place in places.items()} if len(tools) == 1 else places


def _not_inspected(serial: str, *, quarantined: bool) -> TrueloopError:
    why = "is in quarantine" if quarantined else "was not inspected after its finish cut"
    return TrueloopError(
        Code.DIA_NONE,
        f"part {serial!r} {why}: there is nothing to diagnose",
        hint="`trueloop db show` says what is kept of it",
    )


def limits_of(u_um: float | None, limit_um: float | None) -> Repeatability:
    """From micrometres."""
    return Repeatability(*(None if one is None else one / UM_PER_MM for one in (u_um, limit_um)))
