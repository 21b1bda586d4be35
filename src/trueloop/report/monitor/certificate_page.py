"""The certificate of a part as a page: the outcome, each characteristic with its proof, what was in force."""

from typing import Final

from trueloop.report.markup import esc, fields, items, section, table
from trueloop.report.monitor.certificate_shape import CertificateShape, CertifiedShape
from trueloop.report.shell import html_page
from trueloop.report.style import VERDICTS as SIGNS
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.wording import wording

VERDICTS: Final = {"in": wording("in"), "out": wording("out"), "undecided": wording("undecided")}
OUTCOMES: Final = {
    "conforms": wording("Conforms: every characteristic is proven to be inside its limits."),
    "does not conform": wording("Does not conform: at least one characteristic is proven to be outside its limits."),
    "not certified": wording("Not certified: not everything that is asked for is known and proven."),
}
DECIMALS: Final = 4


def certificate_page(shown: CertificateShape, say: Texts = ENGLISH) -> str:
    """The page as HTML in one file."""
    title = f"{esc(shown.part_type)} {esc(shown.serial)}"
    proven = sum(one.certified for one in shown.characteristics)
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
    rows = [_row(one, say) for one in shown.characteristics]
    return table(head, rows, words=(0, 5, 6, 7), name="certificate", stacks=True) + f"<p class='note'>{note}</p>"


def _row(one: CertifiedShape, say: Texts) -> list[str]:
    limits = [_size(limit, one, say) if limit is not None else "" for limit in (one.lower_limit, one.upper_limit)]
    when = "" if one.measured_at is None else f"{one.measured_at:%Y-%m-%d %H:%M}"
    warm = "" if one.temperature_c is None else f"{say.number(one.temperature_c)} °C"
    repeats = say("mean of {n}", n=one.repeats) if one.repeats > 1 else ""
    by = ", ".join(text for text in (esc(one.device), when, warm, repeats) if text)
    said = [f"<b>{esc(say.note(text))}</b>" for text in one.missing] + [esc(say.note(text)) for text in one.remarks]
    return [
        esc(one.characteristic),
        _size(one.nominal, one, say),
        " … ".join(limits) if any(limits) else "",
        _size(one.actual, one, say),
        _size(one.expanded_u, one, say),
        _verdict(one, say),
        by,
        "<br>".join(said),
    ]


def _size(value: float | None, one: CertifiedShape, say: Texts) -> str:
    if value is None:
        return ""
    return f"{say.number(value, DECIMALS)}°" if one.unit == "deg" else say.mm(value, DECIMALS)


def _verdict(one: CertifiedShape, say: Texts) -> str:
    if one.verdict is None or (one.missing and one.verdict == "in"):
        return f'<span class="verdict-undecided">{say("not certified")}</span>'
    sign = SIGNS[one.verdict][1]
    return f'<span class="verdict-{one.verdict}">{sign} {esc(say.note(VERDICTS[one.verdict]))}</span>'


def _in_force(shown: CertificateShape, say: Texts) -> str:
    head = (say("what"), say("hash or id"), say("what is known"))
    rows = [
        [esc(say.note(one.what)), f"<code>{esc(one.identity)}</code>" if one.identity else "", esc(say.note(one.words))]
        for one in shown.in_force
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
    files = dict.fromkeys(one.inspection_sha256 for one in shown.characteristics if one.inspection_sha256)
    listed = items(f"<code>{esc(one)}</code>" for one in files)
    stated = ""
    if shown.stated_u_um is not None:
        stated = say(
            "A standard uncertainty of {u} {um} was stated with this certificate for readings that state none.",
            u=say.size(shown.stated_u_um, 2),
        )
    how = say("The hash is that of the certificate as JSON, keys sorted, without blanks, with its own field empty.")
    return made + f"<p class='note'>{stated} {how}</p><p>{say('Inspections by the hash of their files:')}</p>{listed}"
