"""What the catalogue of causes says of the parts of [6811]: a section of docs/nist-diagnosis.md."""

from collections.abc import Sequence
from functools import cache
from typing import Final

from scripts.nist_errors import Cut, errors, of_family, places_of, table, wrapped
from trueloop.diagnosis.causes.judge import judge
from trueloop.diagnosis.causes.seen_part import SeenBy, SeenPart, SeenSeries
from trueloop.report.diagnosis.names import share
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
        SeenPart(part.number, k, {SeenBy.MACHINE: tuple(errors(part, cut).values())}) for k, part in enumerate(made)
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
    before, after = diagnosed("MODBAS2", "semifinish").causes, diagnosed("MODBAS2", "finish").causes
    assert before is not None and after is not None
    by_key = {one.key: one.probability for one in before.candidates}
    offset = sum(by_key.get(key, 0.0) for key in ("tool-setting", "tool-wear", "part-probe-offset"))
    first = after.candidates[0]
    return (
        "**MODBAS2, semi-finish.** The cylinders err alike on all four parts: offset of the tool, its wear, or offset "
        f"of the part probe ({share(min(offset, 1.0))} together); nothing acts with {share(before.sound)}. The "
        "authors say that the insert was worn. These touches do not tell which of the three it is, without minutes in "
        "cut, a CMM or a standard part, and the diagnosis names none of them alone.",
        "**FACETST.** Tapers typed into the program, others on every part, are none of the catalogue's causes, and it "
        "names none: the last column has them. A job that names the semi-finish program finds them, because the "
        "contour that was programmed differs from the nominal one.",
        "**PIECS11, cones and arcs.** Causes are weighed on cylinders, faces, lengths and tapers of shafts. A worn "
        "nose shows on cones and arcs by the contact angle, which the catalogue does not weigh: the "
        "nose model does, above.",
        f"**MODBAS2, finish.** The likeliest cause is {first.name} ({share(first.probability)}), for some −3 µm on "
        "the small cylinder. Nothing in the report supports it: the authors cut little at a time so that deflection "
        "would be small (§5.1), and a part that gives way is left too large, not too small, unless its correction "
        "went too far. Four parts of a few µm are too little for a name; nothing acts with " + share(after.sound) + ".",
        "**PIECS11, finish.** The mean of the knob stays off by some µm on every part. The authors note that the "
        "errors left on arcs grow towards the next feature (§6).",
    )


def _said(one: UnexplainedShape) -> str:
    between = f"{one.feature} − {one.other}" if one.other else one.feature
    mean = f"{signed(one.size_um, 0)} ± {plain(one.standard_u_um)}"
    return f"{one.kind}, {between}: {mean if one.shows == 'mean' else f'parts differ by {one.size_um:.0f}'}"
