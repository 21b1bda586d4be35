"""How features meet after the correction: displacement of every junction, and tangency of the predicted part."""

import math
from collections.abc import Iterator

from trueloop.loops.turned.correction import Correction
from trueloop.report.markup import esc, items, table
from trueloop.report.style import plain, signed
from trueloop.turned.error_curve.coverage import coverage_factor
from trueloop.turned.error_curve.junctions import DisplacedJunction
from trueloop.turned.error_curve.tangency import Tangency
from trueloop.units import UM_PER_MM

HEADINGS = (
    "between", "kind", "turn<br>°", "error at end<br>µm", "error at start<br>µm", "displaced x<br>µm",
    "displaced z<br>µm", "kink of error<br>µm/mm", "part's tangency<br>µm/mm",
)  # fmt: skip
POLICY = {
    "part": "Tangent junctions by policy <b>part</b>: the curves meet in value, their slopes are free, so that the "
    "path takes the kink opposite to the error's and the part is tangent.",
    "path": "Tangent junctions by policy <b>path</b>: the curves meet in value and slope, so that the path is tangent "
    "and the error's kink stays on the part.",
}
COLUMNS = (
    "Errors are the fitted curves' where one feature ends and the next starts; displaced x and z, where both curves "
    "meet, seen from the nominal junction. Turn is positive at a convex corner. Kink: step of the error's slope across "
    "a tangent junction; the part's tangency is the step predicted to remain on the part (1 µm/mm = 1 mrad)."
)
CLOSED_MM = 1e-6


def junctions(correction: Correction) -> str:
    """The table, what its columns mean, the policy, and which corners could not be closed (HTML)."""
    tangent = f"<p>{POLICY[correction.options.junctions]}</p>" if correction.model.tangency else ""
    return _table(correction) + items(_open_corners(correction)) + tangent + f"<p class='note'>{COLUMNS}</p>"


def _open_corners(correction: Correction) -> Iterator[str]:
    names = correction.profile.names
    for junction in correction.model.junctions:
        if junction.before is not None and junction.after is not None and junction.gap_mm > CLOSED_MM:
            yield f"{esc(names[junction.before])} – {esc(names[junction.after])}: {esc(junction.note)}"


def _table(correction: Correction) -> str:
    """A row a junction, from the chuck end to the free end, the two ends of the profile included."""
    tangencies: dict[tuple[int | None, int | None], Tangency]
    tangencies = {(one.before, one.after): one for one in correction.model.tangency}
    rows, k = [], coverage_factor(correction.model.degrees_of_freedom or None)
    for junction in correction.model.junctions:
        displaced = [
            f"{signed(d * UM_PER_MM)} ± {plain(k * u * UM_PER_MM)}"
            for d, u in zip(junction.displacement_mm, junction.standard_u_mm, strict=True)
        ]
        errors = [_error(junction.error_before_mm), _error(junction.error_after_mm)]
        tangency = tangencies.get((junction.before, junction.after))
        rows.append([*_place(correction, junction), *errors, *displaced, *_tangency(correction, tangency)])
    return table(HEADINGS, rows, words=(0, 1), name="junctions")


def _place(correction: Correction, junction: DisplacedJunction) -> tuple[str, str, str]:
    """Between which features, the kind, and the turn in degrees, positive at a convex corner."""
    names = correction.profile.names
    if junction.before is None or junction.after is None:
        index = junction.after if junction.before is None else junction.before
        which = "start" if junction.before is None else "end"
        return (f"{which} of {esc(names[index])}" if index is not None else "", "end", "")
    met = correction.profile.junctions[junction.before]
    by_design = " by design" if met.by_design else ""
    between = f"{esc(names[junction.before])} – {esc(names[junction.after])}"
    return between, f"{met.kind}{by_design}", signed(math.degrees(met.turn_rad), 2)


def _error(error_mm: float | None) -> str:
    return "" if error_mm is None else signed(error_mm * UM_PER_MM)


def _tangency(correction: Correction, tangency: Tangency | None) -> tuple[str, str]:
    """Kink of the error, and of the predicted part: what a full correction leaves and a weight below 1 keeps."""
    if tangency is None:
        return "", ""
    kept = tangency.predicted_rad + (1.0 - correction.options.weight) * (tangency.kink - tangency.predicted_rad)
    expanded = coverage_factor(correction.model.degrees_of_freedom or None) * tangency.standard_u_um_per_mm
    return signed(tangency.kink * UM_PER_MM, 2), f"{signed(kept * UM_PER_MM, 2)} ± {plain(expanded, 2)}"
