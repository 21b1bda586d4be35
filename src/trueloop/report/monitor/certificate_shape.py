"""The shape of a part's certificate as JSON, with the hash by which it is known."""

import json
from datetime import datetime
from typing import Literal

from pydantic import SkipValidation

from trueloop import __version__
from trueloop.domain.record import sha256_of
from trueloop.loops.monitor.certificate import Certificate, Certified, Outcome
from trueloop.report.shape import Shape


class CertifiedShape(Shape):
    """One characteristic. Sizes are in mm, of angles in degrees."""

    characteristic: str
    """Its name."""
    quantity: str
    """diameter, radius, length, angle, runout, position, form or other."""
    unit: Literal["mm", "deg"]
    """Of its values."""
    nominal: float | None
    """A diameter is a diameter."""
    lower_limit: float | None
    """Null: no limit."""
    upper_limit: float | None
    """Null: no limit."""
    actual: float | None
    """Mean of the repeats; null: it was not measured on this part."""
    expanded_u: float | None
    """U = 2 u."""
    verdict: Literal["in", "out", "undecided"] | None
    """By ISO 14253-1; null: not known."""
    certified: bool
    """Proven inside, with all known that is needed to say so."""
    repeats: int
    """Readings that were averaged."""
    device: str
    """By which it was measured."""
    measured_at: datetime | None
    """When."""
    temperature_c: float | None
    """Of the part then."""
    inspection_sha256: str
    """Of the inspection's file."""
    missing: list[SkipValidation[str]]
    """What is not known, and forbids to certify it."""
    remarks: list[SkipValidation[str]]
    """What the reader has to know."""


class InForceShape(Shape):
    """Something in force when the part was cut."""

    what: SkipValidation[str]
    """machine, program, edge, correction, input of the correction, model, tool offset, proposal."""
    identity: str
    """Its hash or id."""
    words: SkipValidation[str]
    """What is known of it."""


class CertificateShape(Shape):
    """The certificate of one part."""

    part_type: str
    """Its name."""
    revision: str
    """Of the drawing; empty: not stated."""
    serial: str
    """Of the part."""
    outcome: Outcome
    """conforms, does not conform, or not certified."""
    characteristics: list[CertifiedShape]
    """All that inspections of the part type ask for."""
    in_force: list[InForceShape]
    """When it was cut."""
    missing: list[SkipValidation[str]]
    """What is not known of how it was cut."""
    cut_at: datetime | None
    """When it was finished."""
    stated_u_um: float | None
    """Standard uncertainty that was stated for readings that state none, with this certificate."""
    made_at: datetime
    """When the certificate was made."""
    made_by: str
    """By whom."""
    trueloop_version: str
    """By which version."""
    sha256: str
    """Of this document as JSON with sorted keys and without blanks, with this field empty."""


def certificate_shape(done: Certificate, now: datetime, who: str, stated_u_um: float | None) -> CertificateShape:
    """The certificate with its hash."""
    shown = CertificateShape(
        part_type=done.part.part_type.name,
        revision=done.part.part_type.revision,
        serial=done.part.serial,
        outcome=done.outcome,
        characteristics=[_certified(one) for one in done.values],
        in_force=[InForceShape(what=one.what, identity=one.identity, words=one.words) for one in done.in_force],
        missing=list(done.missing),
        cut_at=done.cut_at,
        stated_u_um=stated_u_um,
        made_at=now.replace(microsecond=0),
        made_by=who,
        trueloop_version=__version__,
        sha256="",
    )
    return shown.model_copy(update={"sha256": hash_of(shown)})


def hash_of(shown: CertificateShape) -> str:
    """The hash by which a certificate is known: that of its content without the hash."""
    content = shown.model_copy(update={"sha256": ""}).model_dump(mode="json")
    return sha256_of(json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False).encode())


def _certified(one: Certified) -> CertifiedShape:
    asked, by = one.asked, None if one.by is None else one.by.inspection
    return CertifiedShape(
        characteristic=asked.name,
        quantity=asked.quantity.value,
        unit="deg" if asked.quantity.unit == "deg" else "mm",
        nominal=_round(asked.nominal),
        lower_limit=_round(asked.lower),
        upper_limit=_round(asked.upper),
        actual=_round(one.actual),
        expanded_u=_round(one.expanded_u),
        verdict=None if one.judged is None else one.judged.verdict,
        certified=one.proven,
        repeats=one.repeats,
        device="" if by is None else by.device,
        measured_at=None if by is None else by.measured_at,
        temperature_c=one.temperature_c,
        inspection_sha256="" if by is None else by.sha256,
        missing=list(one.missing),
        remarks=list(one.remarks),
    )


def _round(value: float | None) -> float | None:
    return None if value is None else round(value, 7) + 0.0
