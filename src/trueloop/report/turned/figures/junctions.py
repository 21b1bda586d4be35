"""How features meet after the correction: displacement of every junction, and tangency of the predicted part."""

import math
from collections.abc import Iterator

from trueloop.loops.turned.correction import Correction
from trueloop.report.markup import esc, items, table
from trueloop.report.style import signed
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.turned.error_curve.coverage import coverage_factor
from trueloop.turned.error_curve.junctions import DisplacedJunction
from trueloop.turned.error_curve.tangency import Tangency
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

POLICY = {
    "part": wording(
        "Tangent junctions by policy <b>part</b>: the curves meet in value, their slopes are free, so that the path "
        "takes the kink opposite to the error's and the part is tangent."
    ),
    "path": wording(
        "Tangent junctions by policy <b>path</b>: the curves meet in value and slope, so that the path is tangent and "
        "the error's kink stays on the part."
    ),
}
KINDS = {"tangent": wording("tangent"), "corner": wording("corner"), "apart": wording("apart")}
CLOSED_MM = 1e-6


def junctions(correction: Correction, say: Texts = ENGLISH) -> str:
    """Writes the table, what its columns mean, the policy, and which corners could not be closed (HTML)."""
    columns = say(
        "Errors are the fitted curves' where one feature ends and the next starts; displaced x and z, where both "
        "curves meet, seen from the nominal junction. Turn is positive at a convex corner. Kink: step of the error's "
        "slope across a tangent junction; the part's tangency is the step predicted to remain on the part "
        "(1 µm/mm = 1 mrad)."
    )
    tangent = f"<p>{say.note(POLICY[correction.options.junctions])}</p>" if correction.model.tangency else ""
    flat = list(_open_corners(correction, say))
    return _table(correction, say) + (items(flat) if flat else "") + tangent + f"<p class='note'>{columns}</p>"


def _open_corners(correction: Correction, say: Texts) -> Iterator[str]:
    names = correction.profile.names
    for junction in correction.model.junctions:
        if junction.before is not None and junction.after is not None and junction.gap_mm > CLOSED_MM:
            yield f"{esc(names[junction.before])} – {esc(names[junction.after])}: {esc(say.note(junction.note))}"


def _table(correction: Correction, say: Texts) -> str:
    """A row a junction, from the chuck end to the free end, the two ends of the profile included."""
    tangencies: dict[tuple[int | None, int | None], Tangency]
    tangencies = {(one.before, one.after): one for one in correction.model.tangency}
    rows, k = [], coverage_factor(correction.model.degrees_of_freedom or None)
    for junction in correction.model.junctions:
        displaced = [
            f"{say.error(d * UM_PER_MM)} ± {say.size(k * u * UM_PER_MM)}"
            for d, u in zip(junction.displacement_mm, junction.standard_u_mm, strict=True)
        ]
        errors = [_error(junction.error_before_mm, say), _error(junction.error_after_mm, say)]
        tangency = tangencies.get((junction.before, junction.after))
        rows.append([*_place(correction, junction, say), *errors, *displaced, *_tangency(correction, tangency, say)])
    headings = (
        say("between"), say("kind"), say("turn<br>°"), say("error at end<br>{um}"), say("error at start<br>{um}"),
        say("displaced x<br>{um}"), say("displaced z<br>{um}"),
        say("kink of error<br>{slope}", slope=say.slope_name), say("part's tangency<br>{slope}", slope=say.slope_name),
    )  # fmt: skip
    return table(headings, rows, words=(0, 1), name="junctions", stacks=True)


def _place(correction: Correction, junction: DisplacedJunction, say: Texts) -> tuple[str, str, str]:
    """Between which features, the kind, and the turn in degrees, positive at a convex corner."""
    names = correction.profile.names
    if junction.before is None or junction.after is None:
        index = junction.after if junction.before is None else junction.before
        name = "" if index is None else esc(names[index])
        start = junction.before is None
        return (
            (say("start of {feature}", feature=name) if start else say("end of {feature}", feature=name)),
            say("end"),
            "",
        )
    met = correction.profile.junctions[junction.before]
    kind = say.note(KINDS[met.kind])
    between = f"{esc(names[junction.before])} – {esc(names[junction.after])}"
    kind = say("{kind} by design", kind=kind) if met.by_design else kind
    return between, kind, say.spelled(signed(math.degrees(met.turn_rad), 2))


def _error(error_mm: float | None, say: Texts) -> str:
    return "" if error_mm is None else say.error(error_mm * UM_PER_MM)


def _tangency(correction: Correction, tangency: Tangency | None, say: Texts) -> tuple[str, str]:
    """Kink of the error, and of the predicted part: what a full correction leaves and a weight below 1 keeps."""
    if tangency is None:
        return "", ""
    kept = tangency.predicted_rad + (1.0 - correction.options.weight) * (tangency.kink - tangency.predicted_rad)
    expanded = coverage_factor(correction.model.degrees_of_freedom or None) * tangency.standard_u_um_per_mm
    remains = f"{say.slope(kept * UM_PER_MM)} ± {say.slope(expanded).removeprefix('+')}"
    return say.slope(tangency.kink * UM_PER_MM), remains
