"""Tests whether a fixturing holds: repeats at one point of the part, of the tool probe or of the part probe [4773
§4.1].

The report names a large drift, a step and a large standard deviation. Here three tests say whether repeats do more
than the device explains, and the pattern that explains them best names the cause:

    constant  v = c                     drift    v = c + d·i/(n − 1)
    step      v = c, from k on c + d    warm-up  v = c + d·(1 − exp(−i/κ)), settling within the repeats
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Final

import numpy as np
from scipy import stats

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording

SETTLING: Final = (0.1, 0.15, 0.2, 0.25, 0.3)
"""Time constants of a warm-up that are tried, of the whole time: longer ones are a drift."""
SETTLED: Final = 3.0
"""Time constants after which 95 % of a warm-up is over."""


@dataclass(frozen=True)
class Pattern:
    """A pattern by least squares: `change_mm` is its size, `scatter_mm` one reading's about it, of `spare` residuals.

    `scatter_mm` is what the residuals have, `change_u_mm` follows from that or from what is expected, if that is more.
    `weight` is the logarithm of its likelihood with ½ ln n taken off a parameter, and ln of the number of places or
    time constants that were tried. `at`: the first reading of a step.
    """

    name: str
    change_mm: float
    change_u_mm: float
    scatter_mm: float
    spare: int
    weight: float
    at: int = 0
    settles_after: float | None = None


def step_terms(values: Array) -> tuple[Array, Array]:
    """Of a step at each place 1 … n − 1: mean behind less mean before, and its uncertainty for readings of u = 1."""
    n = len(values)
    before = np.arange(1, n)
    sums = np.cumsum(values)[:-1]
    change = (values.sum() - sums) / (n - before) - sums / before
    return change, np.sqrt(1.0 / before + 1.0 / (n - before))


def _patterns(values: Array, expected_mm: float) -> Iterator[Pattern]:
    i = np.arange(len(values), dtype=np.float64)
    last = i[-1]
    yield _fit("constant", values, expected_mm, None, 1)
    yield _fit("drift", values, expected_mm, i / last, 2)
    for k in range(1, len(values)):
        yield _fit("step", values, expected_mm, (i >= k).astype(np.float64), 3, len(values) - 1, at=k)
    for share in SETTLING:
        constant = share * last
        shape = 1.0 - np.exp(-i / constant)
        yield _fit("warm-up", values, expected_mm, shape, 3, len(SETTLING), settles_after=SETTLED * constant)


def _fit(
    name: str,
    values: Array,
    expected_mm: float,
    shape: Array | None,
    parameters: int,
    tried: int = 1,
    at: int = 0,
    settles_after: float | None = None,
) -> Pattern:
    """A constant and a shape by least squares."""
    n = len(values)
    residual, change, shape_squares = values - values.mean(), 0.0, np.inf
    if shape is not None:
        centred = shape - shape.mean()
        shape_squares = float(centred @ centred)
        change = float(centred @ values) / shape_squares
        residual = residual - change * centred
    squares, spare = float(residual @ residual), n - parameters
    variance = max(squares / n, expected_mm**2)
    weight = -0.5 * (n * np.log(variance) + squares / variance + parameters * np.log(n)) - np.log(tried)
    scatter = float(np.sqrt(squares / spare))
    change_u = max(scatter, expected_mm) / np.sqrt(shape_squares)
    return Pattern(
        name=name,
        change_mm=change,
        change_u_mm=float(change_u),
        scatter_mm=scatter,
        spare=spare,
        weight=float(weight),
        at=at,
        settles_after=settles_after,
    )


FALSE_ALARMS: Final = 0.01
"""Of all three tests together, of a fixturing that holds: a third each."""
EACH: Final = FALSE_ALARMS / 3.0
FEWEST: Final = 5
"""Repeats below which a step cannot be distinguished from a drift."""


class Instability(StrEnum):
    """The result of the tests on repeats."""

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
        """Returns the detected pattern; None: none."""
        return next((one for one in (self.spread, self.drift, self.step) if one.significant), None)


def fixturing(values_mm: Array, standard_u_mm: float, limit_mm: float | None = None) -> Fixturing:
    """Analyses repeats (n,) in order of time; `standard_u_mm` is what one reading is expected to repeat to.

    Significant at 1 % of false alarms, all three together (a third each, Bonferroni; of the n − 1 places of a step
    too), while readings of a fixturing that holds are normal, independent and repeat to `standard_u_mm`: the spread by
    χ² of n − 1, drift and step as normal. If something is, the pattern is the one of the greatest likelihood with
    ½ ln n taken off a parameter (Schwarz) and ln of what was tried, its scatter at least `standard_u_mm`. Raises
    DIA-FEW for less than `FEWEST` finite readings.
    """
    values = np.asarray(values_mm, dtype=np.float64)
    values = values[np.isfinite(values)]
    if len(values) < FEWEST:
        raise _few(len(values))
    n, u = len(values), standard_u_mm
    spread, drift, step, at = _spread(values, u), _drift(values, u), *_step(values, u)
    found = min(spread.p, drift.p, step.p) < EACH
    # The likeliest pattern of readings (n,) in order of time; `expected_mm` is what they scatter by at least
    best = max(_patterns(values, u), key=lambda pattern: pattern.weight)
    shows = (Instability(best.name) if best.name != "constant" else Instability.SPREAD) if found else Instability.NONE
    rest = best.scatter_mm
    spread = replace(spread, value_mm=rest, standard_u_mm=rest / float(np.sqrt(2.0 * best.spare)))
    spread = replace(spread, significant=shows is Instability.SPREAD)
    if best.name in ("drift", "warm-up"):
        drift = replace(drift, value_mm=best.change_mm, standard_u_mm=best.change_u_mm, significant=found)
    if best.name == "step":
        step, at = replace(step, value_mm=best.change_mm, standard_u_mm=best.change_u_mm, significant=found), best.at
    large = [s for s in (spread, drift, step) if s.significant and (limit_mm is None or abs(s.value_mm) > limit_mm)]
    settles = best.settles_after if shows is Instability.WARM_UP else None
    return Fixturing(
        count=n,
        mean_mm=float(values.mean()),
        spread=spread,
        drift=drift,
        step=step,
        step_at=at,
        shows=shows,
        settles_after=settles,
        stable=not large,
        limit_mm=limit_mm,
    )


def unstable(what: str, fixturing: Fixturing) -> Finding | None:
    """Returns the finding DIA-UNSTABLE on a fixturing (of the part, of a probe) that does not hold; None: it holds.

    The limit is the one given, without one what the device's own repeatability explains.
    """
    shown = fixturing.found
    if fixturing.stable or shown is None:
        return None
    limit_mm = shown.explained_mm if fixturing.limit_mm is None else fixturing.limit_mm
    message = wording(
        "{what}: {count} repeats at one point show a {shows} of {size}; the limit is {limit}",
        what=what,
        count=fixturing.count,
        shows=str(fixturing.shows),
        size=Um(shown.value_mm),
        limit=Um(limit_mm),
    )
    return Finding(
        Severity.ERROR,
        Code.DIA_UNSTABLE,
        message,
        _hint(fixturing),
        values={"what": what, "size_um": shown.value_mm * UM_PER_MM, "limit_um": limit_mm * UM_PER_MM},
    )


def _hint(fixturing: Fixturing) -> str:
    if fixturing.shows is Instability.WARM_UP and fixturing.settles_after is not None:
        return wording("wait {count:.0f} readings long until it has settled, and repeat", count=fixturing.settles_after)
    if fixturing.shows is Instability.STEP:
        return wording("something moved before reading {at}: fix it anew, and repeat", at=fixturing.step_at + 1)
    return wording("clean, fix it anew by hand, and repeat; nothing else is concluded until it holds")


def _few(count: int) -> TrueloopError:
    return Code.DIA_FEW.refusal(
        f"{count} repeats at one point; {FEWEST} at least tell a spread, a drift and a step apart",
        hint="touch one point more often right after fixturing",
        values={"count": count, "needed": FEWEST},
    )


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
