"""Diagnoses of parts and series from a store, as shapes."""

from trueloop.errors import Code, TrueloopError
from trueloop.jobs.diagnose.asked import Asked, sources_of
from trueloop.jobs.diagnose.records import part_named
from trueloop.jobs.diagnose.seen_series import parts_of
from trueloop.loops.diagnosis.part import diagnose_part
from trueloop.loops.diagnosis.series import diagnose_series
from trueloop.report.diagnosis.shapes import PartDiagnosisShape, SeriesDiagnosisShape
from trueloop.report.diagnosis.values import part_shape, series_shape
from trueloop.storage.store import Store


def part(store: Store, serial: str, asked: Asked) -> PartDiagnosisShape:
    """One part. Raises DIA errors, and what job and model are refused with."""
    named = part_named(store, serial, asked.part_type)
    sources = sources_of(store, asked, named.part_type.name)
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
    sources = sources_of(store, asked, asked.part_type)
    parts, findings = parts_of(sources)
    done = diagnose_series(parts, sources.places, asked.accept)
    return series_shape(sources.records.part_type, done.series, done.causes, (*findings, *done.findings))


def _not_inspected(serial: str, *, quarantined: bool) -> TrueloopError:
    why = "is in quarantine" if quarantined else "was not inspected after its finish cut"
    return TrueloopError(
        Code.DIA_NONE,
        f"part {serial!r} {why}: there is nothing to diagnose",
        hint="`trueloop db show` says what is kept of it",
    )
