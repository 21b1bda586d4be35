"""`refine`: a machine's model refined, judged on parts left out, with what changed and why in words."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code
from trueloop.machine.model.chain import ErrorName
from trueloop.machine.model.model import MachineModel
from trueloop.machine.refine.left import Change, Guilty, LeftOnParts, UpdatedTerm, changes, guilty_ones, update
from trueloop.statistics import rms
from trueloop.wording import Um, Wording, wording

FOLDS = 10
"""Groups of parts left out one after the other; fewer parts are left out one by one."""
SURE = 2.0
"""Standard uncertainties by which a refined model has to be better."""


@dataclass(frozen=True)
class LeftOut:
    """The residuals of both models in parts left out, mm along the normals, points far off the refined model apart.

    `u_*` are standard uncertainties from the scatter of parts (or, of whole part types, of types). `better_mm` is
    rms_old − rms_new: of the same points, so its uncertainty is smaller than theirs. `gain` is the same with the points
    weighted as they scatter, in standard deviations of a point: a part's set-up moves all its points together, so what
    looks like one counts less.
    """

    groups: int
    points: int
    rms_old_mm: float
    rms_new_mm: float
    largest_old_mm: float
    largest_new_mm: float
    better_mm: float
    u_better_mm: float
    gain: float
    u_gain: float

    @property
    def sure(self) -> bool:
        """Returns whether the new model is better by more than two standard uncertainties."""
        return self.gain > SURE * self.u_gain and not self.worse

    @property
    def worse(self) -> bool:
        """Returns whether the new model leaves more by more than one standard uncertainty, weighted or not."""
        return self.better_mm < -self.u_better_mm or self.gain < -self.u_gain


@dataclass(frozen=True)
class RefinementJudgement:
    """The judgement by parts left out, and by whole part types left out where there are several."""

    by_part: LeftOut
    by_type: LeftOut | None

    @property
    def better(self) -> bool:
        """Returns whether the refined model may be offered: surely better on parts and no worse on types left out."""
        return self.by_part.sure and (self.by_type is None or (self.by_type.gain > 0.0 and not self.by_type.worse))

    @property
    def words(self) -> Wording:
        """Returns the judgement as text."""
        said = wording(
            "{n} parts left out in turn: {old} RMS before, {new} after, better by {better} ± {u}; largest {most_old} "
            "before, {most_new} after.",
            n=self.by_part.groups,
            old=Um(self.by_part.rms_old_mm, ".2f"),
            new=Um(self.by_part.rms_new_mm, ".2f"),
            better=Um(self.by_part.better_mm, ".2f"),
            u=Um(self.by_part.u_better_mm, ".2f"),
            most_old=Um(self.by_part.largest_old_mm, ".2f"),
            most_new=Um(self.by_part.largest_new_mm, ".2f"),
        )
        if self.by_type is None:
            return wording("{parts} One part type only: what it says of others is not known.", parts=said)
        one = self.by_type
        return wording(
            "{parts} {n} part types left out: {old} RMS before, {new} after; largest {most_old} before, {most_new} "
            "after.",
            parts=said,
            n=one.groups,
            old=Um(one.rms_old_mm, ".2f"),
            new=Um(one.rms_new_mm, ".2f"),
            most_old=Um(one.largest_old_mm, ".2f"),
            most_new=Um(one.largest_new_mm, ".2f"),
        )


def judged(
    model: MachineModel, residuals: LeftOnParts, whole: UpdatedTerm, updated: Callable[[LeftOnParts], UpdatedTerm]
) -> RefinementJudgement:
    """Refines anew without each group of parts and without each part type. `whole` is the update by all of them."""
    numbers = residuals.parts
    group = np.searchsorted(numbers, residuals.part) % min(FOLDS, len(numbers))
    types = np.unique(residuals.part_type)
    by_part = _left_out(model, residuals, whole, updated, [group == k for k in np.unique(group)], residuals.part)
    whole_types = [residuals.part_type == one for one in types]
    enough = len(types) > 1 and all(len(np.unique(residuals.part[~out])) >= 3 for out in whole_types)
    unit = residuals.part_type if len(types) > 2 else residuals.part
    by_type = _left_out(model, residuals, whole, updated, whole_types, unit, len(types)) if enough else None
    return RefinementJudgement(by_part, by_type)


def _left_out(
    model: MachineModel,
    residuals: LeftOnParts,
    whole: UpdatedTerm,
    updated: Callable[[LeftOnParts], UpdatedTerm],
    folds: Sequence[Flags],
    unit: Integers,
    groups: int | None = None,
) -> LeftOut:
    left = np.zeros((2, len(residuals)))
    weighted = np.zeros((2, len(residuals)))
    for out in folds:
        held, found = residuals.only(out), updated(residuals.only(~out))
        left[:, out] = held.residual_mm, left_by(model, found.model, held)
        weighted[:, out] = _whitened(held, left[:, out].T, whole).T
    kept = ~whole.outlier
    return _compared(left[:, kept], weighted[:, kept], unit[kept], groups)


def left_by(old: MachineModel, new: MachineModel, residuals: LeftOnParts) -> Array:
    """Returns the residual that the new model would have left where the old one left `residuals.residual_mm`, (n,)."""
    moved = np.einsum("ni,ni->n", residuals.normal, new.error_mm(residuals.state) - old.error_mm(residuals.state))
    left: Array = residuals.residual_mm - moved
    return left


def _whitened(residuals: LeftOnParts, values: Array, term: UpdatedTerm) -> Array:
    """Values (n, k) made as independent as noise, of which each has 1: with the set-ups' and the places' variance.

    Σ = s² (1 + U diag(λ) Uᵀ) with U along what a part's set-up shows: Σ^(−½) = (1 + U (1/√(1 + λ) − 1) Uᵀ) / s.
    """
    left, strength, _ = np.linalg.svd(residuals.set_ups(), full_matrices=False)
    variance = term.noise_mm**2 + term.place_mm**2
    less = 1 / np.sqrt(1 + strength**2 * term.set_up_mm**2 / variance) - 1
    white: Array = (values + left @ (less[:, None] * (left.T @ values))) / np.sqrt(variance)
    return white


def _compared(left: Array, weighted: Array, unit: Integers, groups: int | None) -> LeftOut:
    """Compares old and new: `left` and `weighted` hold both, (2, n)."""
    old, new = (_Level(values, unit) for values in left)
    gain, u_gain = _better(*(_Level(values, unit) for values in weighted))
    better, u_better = _better(old, new)
    return LeftOut(
        groups=groups or len(np.unique(unit)),
        points=left.shape[1],
        rms_old_mm=old.rms,
        rms_new_mm=new.rms,
        largest_old_mm=float(np.abs(left[0]).max()),
        largest_new_mm=float(np.abs(left[1]).max()),
        better_mm=better,
        u_better_mm=u_better,
        gain=gain,
        u_gain=u_gain,
    )


class _Level:
    """RMS of values, and each unit's share of their mean square."""

    def __init__(self, values: Array, unit: Integers) -> None:
        units = np.unique(unit)
        sums = np.array([np.sum(values[unit == one] ** 2) for one in units])
        self.shares, self.rms = sums * len(units) / len(values), rms(values)


def _better(old: _Level, new: _Level) -> tuple[float, float]:
    """Returns by how much the RMS is less, and its standard uncertainty: the mean square's over both RMS."""
    less = old.shares - new.shares
    u = float(np.std(less, ddof=1) / np.sqrt(len(less)))
    return old.rms - new.rms, u / (old.rms + new.rms)


@dataclass(frozen=True)
class Refined:
    """The new model (`offered` gives it a version), the update that made it, and the judgement by parts left out."""

    model: MachineModel
    guilty: tuple[Guilty, ...]
    updated: UpdatedTerm
    judged: RefinementJudgement
    changes: tuple[Change, ...]
    parts: int

    @property
    def reason(self) -> Wording:
        """Returns the reason of the change of the model, in words."""
        named = ", ".join(
            f"{guilty.error}" + (f" ({guilty.signal})" if guilty.signal else "") for guilty in self.guilty
        )
        far_off = int(self.updated.outlier.sum())
        if not named:
            return wording(
                "every error refined within its uncertainty, from what the model left on {parts} parts ({n} points far "
                "off hardly counted)",
                parts=self.parts,
                n=far_off,
            )
        return wording(
            "{errors} refined from what the model left on {parts} parts ({n} points far off hardly counted)",
            errors=named,
            parts=self.parts,
            n=far_off,
        )


def refine(
    model: MachineModel, residuals: LeftOnParts, guilty: Sequence[ErrorName | Guilty], *, share: float = 1.0
) -> Refined:
    """Refines the model by its residuals on the parts, and judges it on parts and part types left out.

    `guilty` are the errors that the diagnosis holds wrong, which may move beyond their covariance. `share` is the part
    of the change that is made [4773 §2.5]. Nothing is refused for being no better: check `judged.better`, or
    `require_better`. Raises what `update` does.
    """
    named = guilty_ones(guilty)
    whole = update(model, residuals, named, share=share)

    def again(others: LeftOnParts) -> UpdatedTerm:
        return update(model, others, named, share=share)

    found = judged(model, residuals, whole, again)
    return Refined(
        model=whole.model,
        guilty=named,
        updated=whole,
        judged=found,
        changes=changes(model, whole.model),
        parts=len(residuals.parts),
    )


def require_better(refined: Refined, accepted: Sequence[Code] = ()) -> None:
    """Refuses a refined model that is no better on parts left out (DIA-WORSE), unless that is among the accepted."""
    if refined.judged.better or Code.DIA_WORSE in accepted:
        return
    raise Code.DIA_WORSE.refusal(
        f"the refined model is not better: {refined.judged.words}",
        hint="inspect more parts, other part types or with other tools, and ask `trueloop diagnose machine` again",
        override="--accept DIA-WORSE",
    )
