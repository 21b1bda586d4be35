"""What the catalogue of causes says of the parts of [6811]: a section of docs/nist-diagnosis.md."""

from collections.abc import Sequence
from functools import cache
from typing import Final

from scripts.nist_errors import Cut, errors, of_family, places_of, seen_points, table, wrapped
from trueloop.diagnosis.causes.cause import SeenBy, SeenPart, SeenSeries
from trueloop.diagnosis.causes.judge import judge
from trueloop.report.diagnosis.causes import share
from trueloop.report.diagnosis.shapes import SeriesDiagnosisShape, UnexplainedShape
from trueloop.report.diagnosis.values import series_shape
from trueloop.report.style import plain, signed

CUTS: Final[tuple[Cut, ...]] = ("semifinish", "finish")
FAMILIES: Final = ("FACETST", "MODBAS2", "PIECS11")


@cache
def diagnosed(family: str, cut: Cut) -> SeriesDiagnosisShape:
    """The parts of one design as a series, in the tables' order."""
    made = of_family(family)
    seen = [
        SeenPart(
            part.number,
            k,
            {SeenBy.MACHINE: tuple(errors(part, cut).values())},
            {SeenBy.MACHINE: seen_points(part, cut)},
        )
        for k, part in enumerate(made)
    ]
    series = SeenSeries(places_of(made[0].profile), tuple(seen))
    return series_shape(family, series, judge(series))


def causes_section() -> str:
    """What the catalogue of causes says of each design and cut."""
    rows = []
    for cut in CUTS:
        for family in FAMILIES:
            found = diagnosed(family, cut)
            assert found.causes is not None
            likely = "; ".join(f"{one.name} {share(one.probability)}" for one in found.causes.candidates[:3])
            unexplained = "; ".join(_said(one) for one in found.unexplained)
            rows.append([f"{family}, {cut}", share(found.causes.sound), likely, unexplained or "–"])
    head = ("Design and cut", "None acts", "Likeliest causes", "Errors that no probable cause explains")
    intro = wrapped(
        "Each design as a series of parts in the tables' order, seen by the machine's probe alone. On the right "
        "stands what is beyond its uncertainty where causes on its feature have less than 50 % together, in µm: the "
        "page of such a series says that no known cause stands out, and not that it is sound."
    )
    said = "\n".join(wrapped(f"- {one}", "  ") for one in _compared())
    return f"## Causes\n\n{intro}\n\n{table(head, rows, 4)}\n\nBeside what the authors say:\n\n{said}\n"


def _compared() -> Sequence[str]:
    worn, after = diagnosed("MODBAS2", "semifinish").causes, diagnosed("MODBAS2", "finish").causes
    typed = diagnosed("FACETST", "semifinish").causes
    assert worn is not None and after is not None and typed is not None
    nose = sum(one.probability for one in worn.candidates if one.key == "nose-form")
    other = sum(one.probability for one in typed.candidates if one.key == "other")
    return (
        "**MODBAS2 and PIECS11, semi-finish.** Errors follow the contact angle, alike on all parts: the form of the "
        f"tool's nose (MODBAS2: {share(nose)}). The authors say that the insert was worn.",
        "**FACETST, semi-finish.** Tapers typed into the program, others on every part, are none of the catalogue's "
        f"causes: something that is not in the catalogue, {share(other)}. A job that names the semi-finish program "
        "finds them, because the contour that was programmed differs from the nominal one.",
        f"**MODBAS2, finish.** Nothing acts with {share(after.sound)}; the report names no cause either.",
        "**PIECS11, finish.** Four micrometres and less are left, on arcs most. The authors note that the errors left "
        "on arcs grow towards the next feature (§6).",
    )


def _said(one: UnexplainedShape) -> str:
    between = f"{one.feature} − {one.other}" if one.other else one.feature
    mean = f"{signed(one.size_um, 0)} ± {plain(one.standard_u_um)}"
    return f"{one.kind}, {between}: {mean if one.shows == 'mean' else f'parts differ by {one.size_um:.0f}'}"
