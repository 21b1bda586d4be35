"""What the diagnosis says of the fourteen parts of [6811] Tables 2–11: errors of features, and causes.

`python -m scripts.nist_diagnosis` prints docs/nist-diagnosis.md, `--write` writes it.

[6811] NISTIR 6811, Process-Intermittent Error Compensation, 2002.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np

from scripts.nist_causes import causes_section
from scripts.nist_errors import errors, of_family, table, wrapped
from scripts.nist_nose import left_on_cones_um
from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError
from trueloop.report.style import plain, signed
from trueloop.units import UM_PER_MM

PAGE: Final = Path(__file__).parents[1] / "docs" / "nist-diagnosis.md"
HEAD: Final = """# What the diagnosis reports for NIST's metal

NISTIR 6811 reports fourteen parts, each touched on the machine after the semi-finish cut and again after a finish cut
that NIST had corrected. Its authors say what they did to them: tapers cut on purpose on FACETST and on some MODBAS2
parts, not which, and a worn insert on MODBAS2 and PIECS11. Here trueloop's diagnosis is given the touches of Tables 4
and 7 to 11, and nothing else.

What it cannot see here: no part was measured on a CMM, so that errors of the machine itself do not show; the machine's
probe repeats them. Depth of cut, minutes in cut, settings of the tool and temperatures are not in the report.

Errors are in µm along the outward normal, + is material left on; ± is a standard uncertainty. That of a touch is 0.5 µm
(§5.1, and rounding); points that deviate from a straight line by more enlarge it. A radius is that at the chuck end
of the feature and a taper goes to its free end, both of the whole feature; NIST gives tapers between the outermost
touches, which are less. `python -m scripts.nist_diagnosis --write` makes this page; a test compares it with what the
code gives.
"""


def _cell(found: Mapping[tuple[str, ErrorKind], FeatureError], feature: str, kind: ErrorKind) -> str:
    one = found.get((feature, kind))
    if one is None:
        return "–"
    return f"{signed(one.value_mm * UM_PER_MM)} ± {plain(one.standard_u_mm * UM_PER_MM)}"


def tapers_section() -> str:
    """FACETST: tapers that were cut on purpose."""
    rows = []
    for part in of_family("FACETST"):
        before, after = errors(part, "semifinish"), errors(part, "finish")
        for feature in ("large-cylinder", "small-cylinder"):
            kinds = (ErrorKind.RADIUS, ErrorKind.SHAFT_TAPER)
            cells = [_cell(found, feature, kind) for found in (before, after) for kind in kinds]
            rows.append([f"{part.number}.{part.semifinish_inspection}", feature, *cells])
        for feature in ("step-face", "end-face"):
            cells = [_cell(found, feature, ErrorKind.FACE_TAPER) for found in (before, after)]
            rows.append([f"{part.number}.{part.semifinish_inspection}", feature, "", cells[0], "", cells[1]])
    head = ("Part", "Feature", "Radius", "Taper", "Radius, finish", "Taper, finish")
    said = wrapped(
        "The report says: deviations of about 12 µm added at the ends of the turning cuts and about 25 µm at those of "
        "the facing cuts, with opposite slopes of the two turning and of the two facing cuts (§5.1)."
    )
    return f"## Tapers cut on purpose (FACETST)\n\n{table(head, rows, 2)}\n\n{said}\n\n{_tapers_said()}\n"


def _tapers_said() -> str:
    """How far the table agrees."""
    found = {part.number + part.semifinish_inspection: errors(part, "semifinish") for part in of_family("FACETST")}
    left = [errors(part, "finish") for part in of_family("FACETST")]
    shaft, face = ErrorKind.SHAFT_TAPER, ErrorKind.FACE_TAPER
    pairs = {
        "turning": [(one["large-cylinder", shaft], one["small-cylinder", shaft]) for one in found.values()],
        "facing": [(one["step-face", face], one["end-face", face]) for one in found.values()],
    }
    opposite = {name: sum(a.value_mm * b.value_mm < 0 for a, b in both) for name, both in pairs.items()}
    near = sum(abs(abs(one.value_mm) - 0.012) < 0.004 for pair in pairs["turning"] for one in pair)
    large = [abs(found["1511561"][name, shaft].value_mm) * UM_PER_MM for name in ("large-cylinder", "small-cylinder")]
    sizes = [abs(one.value_mm) * UM_PER_MM for pair in pairs["facing"] for one in pair]
    sure = sum(_sure(one) for both in pairs.values() for pair in both for one in pair)
    kept = sum(_sure(one) for of in left for (_, kind), one in of.items() if kind in (shaft, face))
    return wrapped(
        f"Of the sixteen tapers {sure} are larger than three standard uncertainties, and {kept} after NIST's "
        f"correction. The slopes are opposite on {opposite['turning']} of 4 parts when turning. When facing they are "
        f"opposite on {opposite['facing']} of 4: on 1411.606 and 1511.608 both faces rise the same way, which the "
        f"report does not say. {near} of 8 turning tapers are 12 ± 4 µm; those of 1511.561 are {large[0]:.0f} and "
        f"{large[1]:.0f} µm, as Table 2 prints, and not 12. Facing tapers are {min(sizes):.0f} to {max(sizes):.0f} µm "
        "over the whole face. Of 1411 the authors read from Table 1 that the small cylinder keeps about −3 µm with "
        "its taper gone, and the step face about +4 µm. Here the small cylinder is −4.5 µm at the chuck end and rises "
        "by 2.4 µm, and the length between the faces is 4 µm short: the same."
    )


def _sure(one: FeatureError) -> bool:
    return abs(one.value_mm) > 3 * one.standard_u_mm


def worn_section() -> str:
    """MODBAS2 and PIECS11: an offset, a worn edge, a cone that is off."""
    left = left_on_cones_um()
    rows = []
    for family, shafts, arc in (
        ("MODBAS2", ("main-cylinder", "small-cylinder"), "dome"),
        ("PIECS11", ("collar", ""), "knob"),
    ):
        for part in of_family(family):
            found = errors(part, "semifinish")
            rows.append(
                [
                    f"{family} {part.number}.{part.semifinish_inspection}",
                    *(_cell(found, name, ErrorKind.RADIUS) for name in shafts),
                    _cell(found, "cone", ErrorKind.RADIUS),
                    _cell(found, "cone", ErrorKind.SHAFT_TAPER),
                    _cell(found, arc, ErrorKind.RADIUS),
                    f"{left[part.number]:+.0f}",
                ]
            )
    head = ("Part", "Cylinder", "Small one", "Cone, radius", "Cone, taper", "Arc, mean", "Cone, left by the nose")
    usual = sorted(value for number, value in left.items() if number != "2811")
    said = (
        f"**Offset.** The cylinders of MODBAS2 are {_range('main-cylinder', ErrorKind.RADIUS)} µm too large: a change "
        "of the tool's offset mends that. The collar of PIECS11 needs none.",
        "**Worn edge.** An offset of that size would leave some 10 µm on the cone, whose normal has 0.87 along x; at "
        f"the chuck end it is {_range('cone', ErrorKind.RADIUS)} µm off. On the arc the error rises and falls with "
        "the contact angle. Both are what the nose has lost where cone and arc touch it: the report names a worn "
        "insert, worn at about 45° (§5.2). A mean over an arc says little, and its "
        "uncertainty, of what the arc errs by, says so.",
        "**A cone that is off.** The wear of the nose, found on the arc alone ([nose-model.md](nose-model.md)), "
        f"explains the cones but for {usual[0]:.0f} to {usual[-1]:.0f} µm (last column; {usual[-1]:.0f} µm on part "
        "3811), alike on both designs. The touches do not say what that is, and the report names no cause.",
        _falsified(left),
    )
    paragraphs = "\n\n".join(wrapped(one) for one in said)
    return f"## An offset, a worn edge, a cone that is off\n\n{table(head, rows)}\n\n{paragraphs}\n"


def _range(feature: str, kind: ErrorKind) -> str:
    """Of the MODBAS2 parts after the semi-finish cut."""
    values = [errors(part, "semifinish")[feature, kind].value_mm * UM_PER_MM for part in of_family("MODBAS2")]
    return f"{min(values):.0f} to {max(values):.0f}"


def falsified() -> dict[str, float]:
    """Taper of each MODBAS2 cone less the mean of the other three, in standard uncertainties of the difference."""
    tapers = {part.number: errors(part, "semifinish")["cone", ErrorKind.SHAFT_TAPER] for part in of_family("MODBAS2")}
    found = {}
    for number, one in tapers.items():
        others = [each for name, each in tapers.items() if name != number]
        u = np.sqrt(one.standard_u_mm**2 + sum(each.standard_u_mm**2 for each in others) / len(others) ** 2)
        found[number] = float((one.value_mm - np.mean([each.value_mm for each in others])) / u)
    return found


def _falsified(left: Mapping[str, float]) -> str:
    tapers = {part.number: errors(part, "semifinish")["cone", ErrorKind.SHAFT_TAPER] for part in of_family("MODBAS2")}
    own, off = tapers.pop("2811"), falsified()
    others = [one.value_mm * UM_PER_MM for one in tapers.values()]
    return (
        f"**A taper falsified on purpose.** The cone of 2811 has a taper of {own.value_mm * UM_PER_MM:+.0f} ± "
        f"{own.standard_u_mm * UM_PER_MM:.0f} µm, the other three {signed(min(others), 0)} to "
        f"{signed(max(others), 0)} µm: it differs from their mean by {off['2811']:.0f} standard uncertainties, and "
        f"the cone stands {left['2811']:.0f} µm off what the nose explains, about twice as much as any other. The "
        "report says that some parts of the family had a mock taper (§5.2), not which; of the four that it prints it "
        "is 2811. The error grows towards the main cylinder, where parameter P47 of the family's "
        "programs moves the end of the cone (§A.3)."
    )


def page() -> str:
    """The whole page."""
    return "\n".join([HEAD, tapers_section(), worn_section(), causes_section()])


def main() -> None:
    """Prints the page, or writes it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true", help="write docs/nist-diagnosis.md")
    if parser.parse_args().write:
        PAGE.write_text(page(), encoding="utf-8")
    else:
        print(page())


if __name__ == "__main__":
    main()
