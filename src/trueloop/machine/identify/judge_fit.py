"""Checks of a fit by its own data: runs that contradict the others, and readings whose unit cannot be right.

A run is predicted from all others (`hold_out`). The slope b of its readings on their prediction, both without the run's
own zero and slope, is 1 within its uncertainty where sign, scale and unit of the run are those of the others. b = −1
stands for a run of the other sign, 1000 for µm in a column of mm.

The residuals of a model in readings it was not made from.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.machine.identify.identify import Identification, values_weight, weighted_rows
from trueloop.machine.identify.observations import (
    Observations,
    instrument_columns,
    orthonormal,
    slope_columns,
    without,
    zero_columns,
)
from trueloop.machine.model.model import MachineModel
from trueloop.statistics import rms
from trueloop.units import MM_PER_INCH, UM_PER_MM, URAD_PER_RAD

Rows = NDArray[np.bool_]

SPARED = 1e-7
"""The share of the information of all runs on a combination of terms that has to be left without one run for the others
to determine it, and that a run has to have for them to predict it."""

FEWEST_PREDICTED = 2
"""Readings of a run, beside what the others do not determine, from which it is compared with them."""


@dataclass(frozen=True)
class Left:
    """The residuals of readings of one kind: RMS of the readings, RMS and largest of reading − model; all in one unit.

    All without the runs' own zeros and slopes, where those are not known. `gain` is the slope of the readings on their
    prediction, `scaled_rms` what gain · prediction leaves of them; `chi2` the mean square of reading − model in units
    of its variance, where that is known, and `others_chi2` that of the other runs, with its degrees of freedom.
    """

    readings: int
    raw: float
    rms: float
    largest: float
    gain: float
    scaled_rms: float
    chi2: float | None = None
    others_chi2: float | None = None
    others_freedom: int = 0


@dataclass(frozen=True)
class Tested:
    """How far the others miss a run: the sum of squares, in units of the stated variances, its degrees of freedom, and
    the share of it that the variance of the coefficients makes where readings scatter by their uncertainty.
    """

    squares: float
    freedom: int
    predicted: float


@dataclass(frozen=True)
class HeldOut:
    """The residuals of one run, lengths and angles apart; None where it has no reading of the kind."""

    run: str
    length_mm: Left | None
    angle_rad: Left | None
    tested: Tested | None = None

    @property
    def by_unit(self) -> dict[str, Left]:
        """Returns the existing residuals as they are printed: in µm, in µrad."""
        kinds = (("µm", self.length_mm, UM_PER_MM), ("µrad", self.angle_rad, URAD_PER_RAD))
        return {unit: _scaled(left, scale) for unit, left, scale in kinds if left}


def compare(model: MachineModel, readings: Observations, run: str = "") -> HeldOut:
    """Compares a model with readings, whose runs' own zeros and slopes are taken out of the residuals.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> found, _ = trueloop.fit_form(machine, form, readings)
    >>> left = trueloop.compare(found.model, readings).by_unit["µm"]
    >>> round(left.raw, 1), round(left.rms, 1)  # RMS of the readings, and of what the model leaves
    (7.7, 0.2)
    """
    chain = model.machine.chain
    opened = np.hstack([zero_columns(readings), slope_columns(chain, readings), instrument_columns(readings)])
    both = np.column_stack([readings.reading, readings.reading - readings.with_lags(model.lags).predicted(model)])
    return _held(run, without(opened, both), readings.is_angle)


def _held(run: str, both: Array, angle: Rows, chi2: float | None = None) -> HeldOut:
    raw, rest = both.T
    length_mm, angle_rad = (_left(raw[rows], rest[rows], chi2) for rows in (~angle, angle))
    return HeldOut(run, length_mm, angle_rad)


def hold_out(
    readings: Observations, found: Identification, refit: Callable[[Observations], MachineModel], *, anew: bool = False
) -> tuple[HeldOut, ...]:
    """Predicts each run from all others, with the weights that readings have in `found`; nothing for a single run.

    The readings of a run are taken out of the normal equations of all. What the others do not determine, as a spindle's
    growth by its only warm run, is taken out of the run, like its own zero: the rest of it is predicted. With `anew`
    (for models that are not linear, or choose) the model is fitted to the others. Runs of which these determine nothing
    are left out of the report.
    """
    runs = list(dict.fromkeys(readings.run))
    if len(runs) < 2:
        return ()
    predicted = None if anew else _Downdated(found, readings)
    judged = []
    for run in runs:
        own = np.array([name == run for name in readings.run])
        judged.append(predicted.without_rows(own, run) if predicted else _refitted(readings, own, run, refit))
    return tuple(left for left in judged if left)


def _refitted(
    readings: Observations, own: Rows, run: str, refit: Callable[[Observations], MachineModel]
) -> HeldOut | None:
    try:
        return compare(refit(readings.only(~own)), readings.only(own), run)
    except TrueloopError:
        return None


class _Downdated:
    """Weighted readings in an orthonormal basis q of model and instruments, less zeros and slopes of runs."""

    def __init__(self, identification: Identification, readings: Observations) -> None:
        machine = identification.model.machine
        whole = readings.with_lags(identification.model.lags)
        rows, values, _ = weighted_rows(machine, identification.model.terms, whole)
        root = np.sqrt(identification.share)
        self.readings, self.root, self.weight = readings, root, values_weight(readings) * root
        self.opened = np.hstack([zero_columns(readings), slope_columns(machine.chain, readings)])
        opened = self.opened * self.weight[:, None]
        shared = instrument_columns(readings)
        columns = np.hstack([rows * root[:, None], shared * self.weight[:, None]])
        self.q = orthonormal(without(opened, columns))
        self.opened = np.hstack([self.opened, shared])
        self.values = without(opened, values * root)
        self.right = self.q.T @ self.values

    def without_rows(self, own: Rows, run: str) -> HeldOut | None:
        """Returns the residuals of rows `own` from all others' equations, without what these leave open; None: all."""
        q, values = self.q[own], self.values[own]
        strength, directions = np.linalg.eigh(np.eye(q.shape[1]) - q.T @ q)
        known = strength >= SPARED
        unknown = q @ directions[:, ~known]
        free = len(q) - int(np.linalg.matrix_rank(unknown)) if unknown.size else len(q)
        seen = without(unknown, q @ directions[:, known])
        if free < FEWEST_PREDICTED or float(np.sum(seen**2)) < SPARED:
            return None
        directions, strength = directions[:, known], strength[known]
        solution = directions @ ((directions.T @ (self.right - q.T @ values)) / strength)
        rest = (values - q @ solution) / self.weight[own]
        opened = np.hstack([self.opened[own], unknown / self.weight[own, None]])
        both = without(opened, np.column_stack([self.readings.reading[own], rest]))
        # The variance of the deviation is I + q S⁻¹ qᵀ; without what is unknown its inverse is I − q (S + qᵀq)⁻¹ qᵀ.
        # Weights of outliers are left out.
        deviation = without(unknown, (values - q @ solution) / self.root[own])
        along = seen.T @ deviation
        chi2 = float(deviation @ deviation - along @ np.linalg.solve(np.diag(strength) + seen.T @ seen, along))
        held = _held(run, both, self.readings.is_angle[own], chi2 / free)
        off = self.values[~own] - self.q[~own] @ solution
        freedom = max(len(off) - int(np.count_nonzero(known)), 1)
        others = float(off @ off) / freedom

        def beside(left: Left | None) -> Left | None:
            return left and replace(left, others_chi2=others, others_freedom=freedom)

        zeros = np.hstack([self.opened[own], unknown])
        tested = Tested(
            squares=float(np.sum(np.minimum(np.abs(deviation), SLIPPED * np.median(np.abs(deviation))) ** 2)),
            freedom=max(len(q) - int(np.linalg.matrix_rank(zeros)), 0),
            predicted=float(np.sum(seen**2 / strength)),
        )
        return HeldOut(run, beside(held.length_mm), beside(held.angle_rad), tested)


def with_lack_of_fit(found: Identification, readings: Observations, held: Sequence[HeldOut]) -> Identification:
    """Returns a model with the covariance that left-out runs show: what it cannot represent, as an error of a rotary
    axis with more waves than segments, displaces predictions by more than readings that scatter independently do.

    Runs that others predict miss by D = σ²F + κP, with the variance σ² of readings about a smooth curve and P from the
    covariance with κ = 1: κ takes the place of the square of the scatter where it is larger beyond chance.
    """
    tested = [held_out.tested for held_out in held if held_out.tested is not None]
    squares, freedom, predicted = (
        sum(getattr(one, name) for one in tested) for name in ("squares", "freedom", "predicted")
    )
    scatter2 = found.scatter**2
    if not predicted > 0.0 or not scatter2 > 0.0:
        return found
    noise2 = min(scatter2, _smooth_noise(found, readings))
    kappa = (squares - noise2 * freedom) / predicted
    if kappa <= scatter2 + CHANCE * noise2 * float(np.sqrt(2 * freedom)) / predicted:
        return found
    model = replace(found.model, covariance=found.model.covariance * (kappa / scatter2))
    return replace(found, model=model, lack_of_fit=float(np.sqrt(kappa / scatter2)))


def _smooth_noise(found: Identification, readings: Observations) -> float:
    """Returns the variance of readings, in units of the stated, about a smooth curve through their neighbours: by the
    second differences of residuals along each run, which take away what the model lacks; infinite for too few.
    """
    weighted, runs = found.residual * values_weight(readings), np.array(readings.run)
    differences = [
        np.diff(weighted[rows], 2)
        for run in dict.fromkeys(readings.run)
        if np.count_nonzero(rows := (runs == run) & ~found.outlier) >= FEWEST_OF_RUN
    ]
    return float(np.mean(np.concatenate(differences) ** 2)) / 6.0 if differences else float("inf")


def _left(raw: Array, rest: Array, chi2: float | None) -> Left | None:
    if not len(raw):
        return None
    predicted = raw - rest
    size = float(predicted @ predicted)
    gain = float(raw @ predicted) / size if size > 0 else 0.0
    return Left(
        readings=len(raw),
        raw=rms(raw),
        rms=rms(rest),
        largest=float(np.abs(rest).max()),
        gain=gain,
        scaled_rms=rms(raw - gain * predicted),
        chi2=chi2,
    )


def _scaled(left: Left, scale: float) -> Left:
    lengths = {name: scale * getattr(left, name) for name in ("raw", "rms", "largest", "scaled_rms")}
    return replace(left, **lengths)


PROPORTIONAL = 0.3
"""RMS that b · prediction may leave of a run, as a share of its readings', for b to stand for the whole run."""

GAIN = 1.25
"""Factor between a run and its prediction from which it is named: no machine's error changes so much between runs."""

CERTAIN = 5.0
"""Standard uncertainties by which a slope differs from 1 where a run is named for it."""

CONTRADICTS = 9.0
"""Mean square of a left-out run's deviations, in units of their predicted variance, from which it contradicts."""

BY_CHANCE = 1e-3
"""Probability by the F distribution that chance makes larger deviations of a left-out run, below which it contradicts
where its readings tell why: the other sign, units mixed up; or of any run that is predicted worse than without a model.
"""

DIFFERS = 1.5
"""As CONTRADICTS where no uncertainty is stated: the scatter, which the wrong run makes larger, is the measure."""

LACK_OF_FIT = 3.0
"""Scatter in units of the stated uncertainty from which the run that fits least is named."""

LEAST_SCATTER = 0.05
"""Scatter, or RMS of a run's readings, in units of the stated uncertainty below which that, or the unit, is wrong."""

MOST_SCATTER = 100.0
"""Scatter in units of the stated uncertainty above which that, or the unit of the readings, is wrong."""

EXACTLY = 1e-9
"""Readings of a run that differ by less are all alike, by rounding."""

SLIPPED = 6.0
"""Median deviations of a run, four standard deviations, as which a reading that is further off counts."""

CHANCE = 2.0
"""Standard deviations by which left-out runs are to miss by more than their readings' scatter explains."""

FEWEST_OF_RUN = 5
"""Readings of a run from which their differences are judged beside its own zero and slope."""

FEWEST = 10
"""Degrees of freedom from which the scatter is judged."""

TRIED = 6
"""Runs at most that are left out one by one to find which is wrong."""

FACTORS: Final = {
    UM_PER_MM: "mm and µm, or µm and nm",
    MM_PER_INCH: "inch and mm",
    URAD_PER_RAD * float(np.radians(1 / 3600)): "arcsec and µrad",
    float(np.degrees(1.0)): "° and rad",
}
"""Which units, mixed up, make such a ratio."""


Judged = tuple[Identification, Sequence[HeldOut]]
"""A model, and each of its runs as predicted from all others."""


@dataclass(frozen=True)
class Contradiction:
    """A run of readings that does not agree with what all others predict of it.

    `gain` is the slope b, NaN where the run is not proportional to its prediction; `rms` and `raw` are the RMS left by
    the prediction and of the readings, in `unit`, `standard_u` their stated uncertainty where they differ by far less.
    `refused`: no model is to be made with it.
    """

    run: str
    unit: str
    gain: float
    rms: float
    raw: float
    refused: bool
    standard_u: float | None = None

    @property
    def message(self) -> str:
        """Returns by how much the run disagrees."""
        if self.standard_u is not None:
            return (
                f"run {self.run!r} differs by {self.raw:.2g} {self.unit} RMS, its readings' stated uncertainty is "
                f"{self.standard_u:.2g} {self.unit}"
            )
        left = f"{self.rms:.2f} {self.unit} RMS off, its readings are {self.raw:.2f} {self.unit}"
        if np.isnan(self.gain):
            return f"run {self.run!r} contradicts the others: predicted from them it is {left}"
        return f"run {self.run!r} reads {self.gain:.3g} times what the other runs predict: {left}"

    @property
    def hint(self) -> str:
        """Returns what may be wrong with it."""
        if self.standard_u is not None:
            return "name the unit that the run is in: reading_mm, reading_um, reading_in; or state its uncertainty"
        if np.isnan(self.gain):
            return "look at positions, axis, direction and unit of the run; or a term is missing in the model"
        if self.gain < 0:
            return "its sign is likely the other way: readings are actual − commanded, tool as seen from the work"
        mixed = _mixed_units(self.gain)
        return f"its unit is likely wrong: {mixed}" if mixed else "look at the scale factor of the instrument in it"


def contradictions(judged: Judged, readings: Observations) -> tuple[Contradiction, ...]:
    """Returns the runs that disagree with what the others predict of them, the least probable first; the least probable
    of all where the model as a whole leaves more than `LACK_OF_FIT` times the stated uncertainty.

    A run is refused where its slope on the prediction is not 1, the prediction leaves more than the readings themselves
    are, beyond chance, or where the readings differ by next to nothing of their uncertainty.
    """
    every = _by_improbability(judged, readings)
    disagreeing = tuple(contradiction for contradiction, wrong in every if wrong)
    if every and not disagreeing and _stated(readings) and judged[0].scatter > LACK_OF_FIT:
        return (every[0][0],)
    return disagreeing


def _by_improbability(judged: Judged, readings: Observations) -> list[tuple[Contradiction, bool]]:
    """Returns how each run lies off what the others predict, the least probable first, and whether it disagrees."""
    found, held = judged
    stated = _stated(readings)
    scatter2 = max(found.scatter, 1.0) ** 2 if stated else found.scatter**2
    every: list[tuple[float, bool, Contradiction]] = []
    for run in held:
        for unit, left in run.by_unit.items():
            gain, chi2 = _certain_gain(left), np.inf if left.chi2 is None else left.chi2
            worse = left.rms > left.raw and left.chi2 is not None and stated
            told = gain < 0 or bool(_mixed_units(gain))
            chance = BY_CHANCE / (1 if told else len(held))
            limit = _by_chance(left.readings, found.degrees_of_freedom, chance) if told or worse else CONTRADICTS
            wrong = chi2 > (limit if stated else DIFFERS) * scatter2 and (worse or not np.isnan(gain))
            if stated and left.others_chi2 is not None and not np.isnan(gain):  # the run may make the scatter
                limit = _by_chance(left.readings, left.others_freedom, BY_CHANCE / len(held))
                wrong |= chi2 > max(limit, CONTRADICTS) * max(left.others_chi2, 1.0)
            u = _stated_u(readings, run.run, unit)
            small = left.readings >= FEWEST_OF_RUN and u * EXACTLY < left.raw < u * LEAST_SCATTER
            contradiction = Contradiction(
                run=run.run,
                unit=unit,
                gain=gain,
                rms=left.rms,
                raw=left.raw,
                refused=small or wrong,
                standard_u=u if small else None,
            )
            every.append((-np.inf if small else -chi2, small or wrong, contradiction))
    every.sort(key=lambda entry: entry[0])
    return [(contradiction, wrong) for _, wrong, contradiction in every]


def _by_chance(readings: int, degrees_of_freedom: int, chance: float) -> float:
    """Returns the mean square of a run's deviations, in units of the scatter's, that this probability exceeds."""
    from scipy.special import fdtri

    return float(fdtri(readings, max(degrees_of_freedom, 1), 1.0 - chance))


def _stated_u(readings: Observations, run: str, unit: str) -> float:
    """Returns the median stated uncertainty of a run's lengths, µm, or angles, µrad; NaN where none is stated."""
    rows = (np.array(readings.run) == run) & (readings.is_angle == (unit == "µrad"))
    return float(np.median(readings.standard_u[rows])) * (URAD_PER_RAD if unit == "µrad" else UM_PER_MM)


def _certain_gain(left: Left) -> float:
    """Returns the slope of a run on its prediction where it is certain and not 1, else NaN."""
    if not left.scaled_rms < PROPORTIONAL * left.raw or left.readings < 3:
        return float("nan")
    u = abs(left.gain) * left.scaled_rms / left.raw / np.sqrt(left.readings - 1)
    near = left.gain > 0 and abs(np.log(left.gain)) < np.log(GAIN)
    return float("nan") if near or abs(left.gain - 1.0) < CERTAIN * u else left.gain


def _mixed_units(gain: float) -> str:
    """Returns which units, mixed up, make such a slope; empty where none do."""
    near = [words for factor, words in FACTORS.items() if abs(abs(np.log(abs(gain))) - np.log(factor)) < 0.1]
    return near[0] if near else ""


def require_agreement(
    judged: Judged, readings: Observations, refit: Callable[[Observations], Judged], accepted: Sequence[str] = ()
) -> tuple[Finding, ...]:
    """Returns a warning for each run that disagrees, as `contradictions`, and for those that the others do not
    predict.

    Raises MCH-RUN for runs of which no model is to be made, MCH-SCATTER where all readings scatter by less than a
    twentieth or more than a hundredfold of their stated uncertainty, unless the code is among the accepted. The runs
    named are those without which all others agree, where there are such.
    """
    found = judged[0]
    judgeable = _stated(readings) and found.degrees_of_freedom >= FEWEST and Code.MCH_SCATTER not in accepted
    if judgeable and found.scatter < LEAST_SCATTER:
        raise _unlikely_scatter(found.scatter, len(readings))
    wrong = contradictions(judged, readings)
    if any(contradiction.refused for contradiction in wrong) and Code.MCH_RUN not in accepted:
        raise _refusal(wrong, judged, readings, refit)
    if judgeable and found.scatter > MOST_SCATTER:  # one wrong run is better named than the scatter that it makes
        raise _unlikely_scatter(found.scatter, len(readings))
    return (
        *(_warning(contradiction.message, contradiction.hint, [contradiction.run]) for contradiction in wrong),
        *_unchecked(judged[1], readings),
    )


def _warning(message: str, hint: str, runs: Sequence[str]) -> Finding:
    return Finding(Severity.WARNING, Code.MCH_RUN, message, hint=hint, values={"runs": list(runs)})


def _unchecked(held: Sequence[HeldOut], readings: Observations) -> Iterator[Finding]:
    """Yields the warning of runs of which the others predict nothing."""
    predicted = {held_out.run for held_out in held}
    alone = [run for run in dict.fromkeys(map(str, readings.run)) if run not in predicted]
    if alone:
        names = ", ".join(map(repr, alone))
        message = f"{len(alone)} of {len(predicted) + len(alone)} runs are not predicted by the others: {names}"
        hint = "a wrong sign or unit in them would not be noticed: repeat each, in the same state of the machine"
        yield _warning(message, hint, alone)


def _refusal(
    wrong: Sequence[Contradiction], judged: Judged, readings: Observations, refit: Callable[[Observations], Judged]
) -> TrueloopError:
    """Names the runs without which all others agree; else all that disagree."""
    least_probable = [contradiction for contradiction, _ in _by_improbability(judged, readings)]
    suspects = {contradiction.run: contradiction for contradiction in (*reversed(least_probable), *reversed(wrong))}
    tried = list(reversed(suspects.values()))[:TRIED]
    agree = {
        contradiction.run: _agrees(readings.only(np.array(readings.run) != contradiction.run), refit)
        for contradiction in tried
    }
    alone = [
        contradiction
        for contradiction in tried
        if agree[contradiction.run] or (agree[contradiction.run] is None and contradiction in wrong)
    ]
    named = alone or list(wrong[:TRIED])
    either = f"; one of these {len(named)} runs is wrong" if len(named) > 1 else ""
    either += (
        ", the others agree" if len(alone) > 1 and all(agree[contradiction.run] for contradiction in alone) else ""
    )
    return Code.MCH_RUN.refusal(
        "; ".join(contradiction.message for contradiction in named),
        hint=named[0].hint + either,
        override="--accept MCH-RUN",
        values={"runs": [contradiction.run for contradiction in named]},
    )


def _agrees(readings: Observations, refit: Callable[[Observations], Judged]) -> bool | None:
    """Returns whether the readings make a model that no run contradicts; None where they make none."""
    try:
        return not contradictions(refit(readings), readings)
    except TrueloopError:
        return None


def _stated(readings: Observations) -> bool:
    return bool(np.all(np.isfinite(readings.standard_u)))


def _unlikely_scatter(scatter: float, count: int) -> TrueloopError:
    return Code.MCH_SCATTER.refusal(
        f"{count} readings scatter by {scatter:.3g} times their stated standard uncertainty",
        hint="name the unit that the readings are in: reading_mm, reading_um, reading_in; or state the uncertainty "
        "they have",
        override="--accept MCH-SCATTER",
        values={"scatter": scatter},
    )
