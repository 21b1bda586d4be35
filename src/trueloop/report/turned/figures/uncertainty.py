"""What the uncertainty of every feature is made up of."""

from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.outcome import EARLIER_PARTS, Outcome, between_cuts_words, causes_um, outcomes
from trueloop.report.markup import esc, table
from trueloop.report.style import plain
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.units import UM_PER_MM


def uncertainty(correction: Correction, say: Texts = ENGLISH) -> str:
    """Writes the budget of every feature, what its columns mean, and the source of the figures between cuts (HTML)."""
    headings = (
        say("feature"), say("probe"), say("curve"), say("process"), say("between cuts,<br>whole cut"),
        say("between cuts,<br>along the cut"), say("no touch"),
        *((say("earlier parts"),) if _by_memory(correction) else ()), say("U (95 %)"),
    )  # fmt: skip
    columns = say(
        "Standard uncertainties of the finished part's error in {um}, at the place of the feature where U is largest. "
        "Probe: its repeatability, in the fitted curve. Curve: the scatter of the touched cut, in the fitted curve. "
        "Process: the scatter of the finish cut by itself. Between cuts: what the finish cut does otherwise than the "
        "semi-finish cut, which the touches of one part cannot show. No touch: of an error that was estimated from "
        "other features."
    )
    if _by_memory(correction):
        columns += " " + say("Earlier parts: all of the next cut's error, its scatter included, where they tell it.")
    rows = [_row(correction, one, say) for one in outcomes(correction)]
    words = esc(say.note(between_cuts_words(correction.options.between_cuts)))
    return f"{table(headings, rows, words=(0,), name='budget', stacks=True)}<p>{words}</p><p class='note'>{columns}</p>"


def budget_words(correction: Correction) -> str:
    """Describes the largest of each cause over all features, as plain text."""
    causes = [causes_um(outcome.budget) for outcome in outcomes(correction)]
    named = {cause: None for one in causes for cause in one}
    largest = ", ".join(f"{cause} {plain(max(one.get(cause, 0.0) for one in causes))}" for cause in named)
    return f"Uncertainty budget, largest standard uncertainties in µm: {largest}."


def _by_memory(correction: Correction) -> bool:
    return any(curve.next_cut is not None for curve in correction.model.curves)


def _row(correction: Correction, outcome: Outcome, say: Texts) -> list[str]:
    found = causes_um(outcome.budget)
    if _by_memory(correction):
        found.setdefault(EARLIER_PARTS, 0.0)
    causes = [say.size(um) for um in found.values()]
    return [esc(correction.profile.names[outcome.index]), *causes, say.size(outcome.expanded_u_mm * UM_PER_MM)]
