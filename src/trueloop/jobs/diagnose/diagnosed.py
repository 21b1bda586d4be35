"""Diagnoses of parts and series from a store, as shapes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

from trueloop.diagnosis.features.feature_error import FeaturePlace
from trueloop.domain.part import Part
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.jobs.diagnose.both import given_model
from trueloop.jobs.diagnose.records import Records, part_named, read_records, types_of
from trueloop.jobs.diagnose.seen_series import Sources, parts_of
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.shares import shares_of
from trueloop.loops.diagnosis.part import diagnose_part, diagnose_series
from trueloop.loops.diagnosis.points_of import places_of
from trueloop.loops.turned import correction as turned
from trueloop.report.diagnosis.shapes import PartDiagnosisShape, SeriesDiagnosisShape
from trueloop.report.diagnosis.values import part_shape, series_shape
from trueloop.storage.store import Store


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
