"""The certificate of a part: shape of its JSON, lines and page."""

import json
from collections.abc import Iterator
from datetime import datetime
from typing import Final, Literal

from pydantic import SkipValidation

from trueloop import __version__
from trueloop.domain.record import sha256_of
from trueloop.loops.monitor.certificate import Certificate, CertifiedSize, Outcome
from trueloop.report.markup import esc, fields, html_page, items, section, table
from trueloop.report.shape import Shape
from trueloop.report.style import VERDICTS as SIGNS
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.wording import wording


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
    """Unknowns that forbid to certify it."""
    remarks: list[SkipValidation[str]]
    """Remarks for the reader."""


class InForceShape(Shape):
    """Something in force when the part was cut."""

    what: SkipValidation[str]
    """machine, program, edge, correction, input of the correction, model, tool offset, proposal."""
    identity: str
    """Its hash or id."""
    words: SkipValidation[str]
    """Its description."""


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
    """Unknowns of its cut."""
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
    """Makes the certificate with its hash."""
    shown = CertificateShape.from_values(
        *(done, done.part, done.part.part_type),
        part_type=done.part.part_type.name,
        characteristics=[_certified(size) for size in done.values],
        in_force=[InForceShape.from_values(in_force) for in_force in done.in_force],
        stated_u_um=stated_u_um,
        made_at=now.replace(microsecond=0),
        made_by=who,
        trueloop_version=__version__,
        sha256="",
    )
    return shown.model_copy(update={"sha256": hash_of(shown)})


def hash_of(shown: CertificateShape) -> str:
    """Returns the hash by which a certificate is known: that of its content without the hash."""
    content = shown.model_copy(update={"sha256": ""}).model_dump(mode="json")
    return sha256_of(json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False).encode())


def _certified(size: CertifiedSize) -> CertifiedShape:
    asked, by = size.asked, None if size.by is None else size.by.inspection
    return CertifiedShape.from_values(
        *(size, asked),
        characteristic=asked.name,
        unit="deg" if asked.quantity.unit == "deg" else "mm",
        nominal=_round(asked.nominal),
        lower_limit=_round(asked.lower),
        upper_limit=_round(asked.upper),
        actual=_round(size.actual),
        expanded_u=_round(size.expanded_u),
        verdict=None if size.judged is None else size.judged.verdict,
        certified=size.proven,
        device="" if by is None else by.device_of(asked.name),
        measured_at=None if by is None else by.measured_at,
        inspection_sha256="" if by is None else by.sha256,
    )


def _round(value: float | None) -> float | None:
    return None if value is None else round(value, 7) + 0.0


HEAD = ("characteristic", "limits", "actual", "U (k = 2)", "verdict", "by", "not known")


def certificate_rows(shown: CertificateShape) -> Iterator[tuple[str, ...]]:
    """Cells of a table, one row a characteristic; mm, of angles degrees."""
    for characteristic in shown.characteristics:
        limits = [
            "" if limit is None else f"{limit:.4f}"
            for limit in (characteristic.lower_limit, characteristic.upper_limit)
        ]
        yield (
            characteristic.characteristic,
            " … ".join(limits),
            "" if characteristic.actual is None else f"{characteristic.actual:.4f}",
            "" if characteristic.expanded_u is None else f"{characteristic.expanded_u:.4f}",
            (characteristic.verdict or "")
            if characteristic.verdict == "out" or not characteristic.missing
            else "not certified",
            characteristic.device,
            "; ".join(characteristic.missing),
        )


def in_force_lines(shown: CertificateShape) -> Iterator[str]:
    """Yields what was in force, what is not known of it, and the certificate's hash."""
    for shape in shown.in_force:
        yield " ".join(text for text in (f"{shape.what}:", shape.identity, shape.words and f"({shape.words})") if text)
    yield from (f"not known: {text}" for text in shown.missing)
    yield f"sha256 {shown.sha256}"


VERDICTS: Final = {"in": wording("in"), "out": wording("out"), "undecided": wording("undecided")}
OUTCOMES: Final = {
    "conforms": wording("Conforms: every characteristic is proven to be inside its limits."),
    "does not conform": wording("Does not conform: at least one characteristic is proven to be outside its limits."),
    "not certified": wording("Not certified: not everything that is asked for is known and proven."),
}
DECIMALS: Final = 4


def certificate_page(shown: CertificateShape, say: Texts = ENGLISH) -> str:
    """Writes the page as HTML in one file."""
    title = f"{esc(shown.part_type)} {esc(shown.serial)}"
    proven = sum(characteristic.certified for characteristic in shown.characteristics)
    counts = say("{n} of {all} characteristics are certified.", n=proven, all=len(shown.characteristics))
    body = (
        f'<header><p class="kicker">{say("trueloop · certificate of a part")}</p><h1>{title}</h1>'
        f'<p class="verdict">{say.note(OUTCOMES[shown.outcome])} {counts}</p>{_head(shown, say)}</header>'
        + section("characteristics", say("Characteristics"), _table(shown, say))
        + section("in-force", say("In force when it was cut"), _in_force(shown, say))
        + _missing(shown, say)
        + section("document", say("This document"), _document(shown, say))
    )
    return html_page(f"{title} – {say('certificate')}", body, language=say.language)


def _head(shown: CertificateShape, say: Texts) -> str:
    return fields(
        (
            (say("Part"), esc(shown.part_type)),
            (say("Revision"), esc(shown.revision)),
            (say("Serial number"), esc(shown.serial)),
            (say("Finished"), "" if shown.cut_at is None else f"{shown.cut_at:%Y-%m-%d %H:%M}"),
        )
    )


def _table(shown: CertificateShape, say: Texts) -> str:
    head = (
        say("characteristic"), say("nominal"), say("limits"), say("measured"), say("± U (k = 2)"), say("verdict"),
        say("measured by"), say("not known, and remarks"),
    )  # fmt: skip
    note = say(
        "Lengths in {mm}, angles in degrees. Verdicts by ISO 14253-1: in where it is inside both limits by 1.645 u, "
        "out where it is outside one of them by as much. A diameter is a diameter."
    )
    rows = [_row(characteristic, say) for characteristic in shown.characteristics]
    return table(head, rows, words=(0, 5, 6, 7), name="certificate", stacks=True) + f"<p class='note'>{note}</p>"


def _row(size: CertifiedShape, say: Texts) -> list[str]:
    limits = [_size(limit, size, say) if limit is not None else "" for limit in (size.lower_limit, size.upper_limit)]
    when = "" if size.measured_at is None else f"{size.measured_at:%Y-%m-%d %H:%M}"
    warm = "" if size.temperature_c is None else f"{say.number(size.temperature_c)} °C"
    repeats = say("mean of {n}", n=size.repeats) if size.repeats > 1 else ""
    by = ", ".join(text for text in (esc(size.device), when, warm, repeats) if text)
    said = [f"<b>{esc(say.note(text))}</b>" for text in size.missing] + [esc(say.note(text)) for text in size.remarks]
    return [
        esc(size.characteristic),
        _size(size.nominal, size, say),
        " … ".join(limits) if any(limits) else "",
        _size(size.actual, size, say),
        _size(size.expanded_u, size, say),
        _verdict(size, say),
        by,
        "<br>".join(said),
    ]


def _size(value: float | None, size: CertifiedShape, say: Texts) -> str:
    if value is None:
        return ""
    return f"{say.number(value, DECIMALS)}°" if size.unit == "deg" else say.mm(value, DECIMALS)


def _verdict(size: CertifiedShape, say: Texts) -> str:
    if size.verdict is None or (size.missing and size.verdict == "in"):
        return f'<span class="verdict-undecided">{say("not certified")}</span>'
    sign = SIGNS[size.verdict][1]
    return f'<span class="verdict-{size.verdict}">{sign} {esc(say.note(VERDICTS[size.verdict]))}</span>'


def _in_force(shown: CertificateShape, say: Texts) -> str:
    head = (say("what"), say("hash or id"), say("what is known"))
    rows = [
        [
            esc(say.note(shape.what)),
            f"<code>{esc(shape.identity)}</code>" if shape.identity else "",
            esc(say.note(shape.words)),
        ]
        for shape in shown.in_force
    ]
    return table(head, rows, words=(0, 1, 2), stacks=True) if rows else f"<p>{say('Nothing is known.')}</p>"


def _missing(shown: CertificateShape, say: Texts) -> str:
    if not shown.missing:
        return ""
    return section("missing", say("Not known"), items(esc(say.note(one)) for one in shown.missing))


def _document(shown: CertificateShape, say: Texts) -> str:
    made = fields(
        (
            (say("Made"), f"{shown.made_at:%Y-%m-%d %H:%M} UTC"),
            (say("By"), esc(shown.made_by)),
            (say("Version"), esc(shown.trueloop_version)),
            ("SHA-256", f"<code>{shown.sha256}</code>"),
        )
    )
    files = dict.fromkeys(
        characteristic.inspection_sha256 for characteristic in shown.characteristics if characteristic.inspection_sha256
    )
    listed = items(f"<code>{esc(one)}</code>" for one in files)
    stated = ""
    if shown.stated_u_um is not None:
        stated = say(
            "A standard uncertainty of {u} {um} was stated with this certificate for readings that state none.",
            u=say.size(shown.stated_u_um, 2),
        )
    how = say("The hash is that of the certificate as JSON, keys sorted, without blanks, with its own field empty.")
    return made + f"<p class='note'>{stated} {how}</p><p>{say('Inspections by the hash of their files:')}</p>{listed}"
