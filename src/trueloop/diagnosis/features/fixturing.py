"""Whether a fixturing holds: repeats at one point of the part, of the tool probe or of the part probe [4773 §4.1].

The report names a large drift, a step and a large standard deviation. Here three tests say whether repeats do more
than the device explains, and the pattern that explains them best says what it is:

    constant  v = c                     drift    v = c + d·i/(n − 1)
    step      v = c, from k on c + d    warm-up  v = c + d·(1 − exp(−i/κ)), settling within the repeats
"""

from dataclasses import dataclass, replace
from enum import StrEnum
from math import ceil
from typing import Final

import numpy as np
from scipy import stats

from trueloop.arrays import Array
from trueloop.diagnosis.features.patterns import Pattern, best_pattern, step_terms
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording

FALSE_ALARMS: Final = 0.01
"""Of all three tests together, of a fixturing that holds: a third each."""
EACH: Final = FALSE_ALARMS / 3.0
FEWEST: Final = 5
"""Repeats below which a step cannot be told from a drift."""
POWER: Final = 0.9


class Instability(StrEnum):
    """What repeats show."""

    NONE = "none"
    SPREAD = "spread"
    DRIFT = "drift"
    WARM_UP = "warm-up"
    STEP = "step"


@dataclass(frozen=True)
class Shown:
    """One way to be unstable: its size with the standard uncertainty, and whether that is what the repeats show.

    `explained_mm` is the size up to which the device's own repeatability explains it, `p` the probability that repeats
    of a fixturing that holds look so, in the test of this way alone.
    """

    value_mm: float
    standard_u_mm: float
    explained_mm: float
    p: float
    significant: bool


@dataclass(frozen=True)
class Fixturing:
    """Repeats at one point. `spread` is the standard deviation of one reading about the pattern.

    `drift` is the change from the first to the last, `step` that at reading `step_at` (from 0). `shows` names the
    pattern that explains them best; of a warm-up, `drift` is significant and `settles_after` readings 95 % of it is
    over. `stable`: nothing is significant and larger than the limit, where there is one.
    """

    count: int
    mean_mm: float
    spread: Shown
    drift: Shown
    step: Shown
    step_at: int
    shows: Instability
    settles_after: float | None
    stable: bool
    limit_mm: float | None = None

    @property
    def found(self) -> Shown | None:
        """What it shows; None: nothing."""
        return next((one for one in (self.spread, self.drift, self.step) if one.significant), None)


def fixturing(values_mm: Array, standard_u_mm: float, limit_mm: float | None = None) -> Fixturing:
    """What repeats (n,) in order of time show; `standard_u_mm` is what one reading is expected to repeat to.

    Significant at 1 % of false alarms, all three together (a third each, Bonferroni; of the n − 1 places of a step
    too), while readings of a fixturing that holds are normal, independent and repeat to `standard_u_mm`: the spread by
    χ² of n − 1, drift and step as normal. If something is, the pattern is the one of the greatest likelihood with
    ½ ln n taken off a parameter (Schwarz) and ln of what was tried, its scatter at least `standard_u_mm`. Raises
    DIA-FEW for less than `FEWEST` finite readings; how many a step of some size needs: `repeats_needed`.
    """
    values = np.asarray(values_mm, dtype=np.float64)
    values = values[np.isfinite(values)]
    if len(values) < FEWEST:
        raise _few(len(values))
    n, u = len(values), standard_u_mm
    spread, drift, step, at = _spread(values, u), _drift(values, u), *_step(values, u)
    found = min(spread.p, drift.p, step.p) < EACH
    best = best_pattern(values, u)
    shows = (_named(best) if best.name != "constant" else Instability.SPREAD) if found else Instability.NONE
    rest = best.scatter_mm
    spread = replace(spread, value_mm=rest, standard_u_mm=rest / float(np.sqrt(2.0 * best.spare)))
    spread = replace(spread, significant=shows is Instability.SPREAD)
    if best.name in ("drift", "warm-up"):
        drift = replace(drift, value_mm=best.change_mm, standard_u_mm=best.change_u_mm, significant=found)
    if best.name == "step":
        step, at = replace(step, value_mm=best.change_mm, standard_u_mm=best.change_u_mm, significant=found), best.at
    large = [s for s in (spread, drift, step) if s.significant and (limit_mm is None or abs(s.value_mm) > limit_mm)]
    settles = best.settles_after if shows is Instability.WARM_UP else None
    return Fixturing(n, float(values.mean()), spread, drift, step, at, shows, settles, not large, limit_mm)


def repeats_needed(size_mm: float, standard_u_mm: float) -> int:
    """Repeats that find a step of this size in their middle with a probability of 90 %, at least `FEWEST`.

    Its mean differs by size·√n/2 in standard uncertainties. A drift of the same size from end to end needs three times
    as many.
    """
    needed = FEWEST
    for _ in range(20):
        critical = stats.norm.isf(EACH / 2.0 / (needed - 1)) + stats.norm.ppf(POWER)
        needed = max(FEWEST, ceil((2.0 * critical * standard_u_mm / size_mm) ** 2))
    return needed


def unstable(what: str, found: Fixturing) -> Finding | None:
    """What is to be said of a fixturing (of the part, of a probe) that does not hold: DIA-UNSTABLE; None: it holds.

    The limit is the one given, without one what the device's own repeatability explains.
    """
    shown = found.found
    if found.stable or shown is None:
        return None
    limit_mm = shown.explained_mm if found.limit_mm is None else found.limit_mm
    message = wording(
        "{what}: {count} repeats at one point show a {shows} of {size}; the limit is {limit}",
        what=what,
        count=found.count,
        shows=str(found.shows),
        size=Um(shown.value_mm),
        limit=Um(limit_mm),
    )
    return Finding(
        Severity.ERROR,
        Code.DIA_UNSTABLE,
        message,
        _hint(found),
        values={"what": what, "size_um": shown.value_mm * UM_PER_MM, "limit_um": limit_mm * UM_PER_MM},
    )


def _hint(found: Fixturing) -> str:
    if found.shows is Instability.WARM_UP and found.settles_after is not None:
        return wording("wait {count:.0f} readings long until it has settled, and repeat", count=found.settles_after)
    if found.shows is Instability.STEP:
        return wording("something moved before reading {at}: fix it anew, and repeat", at=found.step_at + 1)
    return wording("clean, fix it anew by hand, and repeat; nothing else is concluded until it holds")


def _few(count: int) -> TrueloopError:
    return TrueloopError(
        Code.DIA_FEW,
        f"{count} repeats at one point; {FEWEST} at least tell a spread, a drift and a step apart",
        hint="touch one point more often right after fixturing",
        values={"count": count, "needed": FEWEST},
    )


def _named(best: Pattern) -> Instability:
    return Instability(best.name)


def _spread(values: Array, u: float) -> Shown:
    """Standard deviation against the expected one, one-sided."""
    freedom, s = len(values) - 1, float(np.std(values, ddof=1))
    explained = u * float(np.sqrt(stats.chi2.isf(EACH, freedom) / freedom))
    p = float(stats.chi2.sf(freedom * (s / u) ** 2, freedom))
    return Shown(s, s / float(np.sqrt(2.0 * freedom)), explained, p, False)


def _drift(values: Array, u: float) -> Shown:
    """Change from the first to the last by the least-squares line."""
    i = np.linspace(-0.5, 0.5, len(values))
    value, its_u = float(i @ values / (i @ i)), u / float(np.sqrt(i @ i))
    explained = its_u * float(stats.norm.isf(EACH / 2.0))
    return Shown(value, its_u, explained, float(2.0 * stats.norm.sf(abs(value) / its_u)), False)


def _step(values: Array, u: float) -> tuple[Shown, int]:
    """The most significant step of all places."""
    change, its_u = step_terms(values)
    k = int(np.argmax(np.abs(change) / its_u))
    p = min(1.0, len(change) * 2.0 * float(stats.norm.sf(abs(change[k]) / (its_u[k] * u))))
    explained = float(its_u[k]) * u * float(stats.norm.isf(EACH / 2.0 / len(change)))
    return Shown(float(change[k]), float(its_u[k]) * u, explained, p, False), k + 1
