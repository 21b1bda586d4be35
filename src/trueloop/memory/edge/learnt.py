"""What an edge has taught: its form, the transfer to the finish cut, its setting, and what each part type adds.

Each is a term of the model of `memory.edge.terms`, given all errors of the parts behind it: mean K_ty K⁻¹ y, covariance
K_tt − K_ty K⁻¹ K_yt, with K_ty the covariance of the term in a cut and the errors y.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.memory.edge.hyperparameters import Hyperparameters
from trueloop.memory.edge.observations import Observations, cuts_of, observations
from trueloop.memory.edge.posterior import joint
from trueloop.memory.edge.predict import sizes
from trueloop.memory.edge.terms import along_angle, between_cuts, terms
from trueloop.memory.made_part import ArcErrors, MadePart

LATEST: Final = 40
"""Of so many parts at most: what an edge was long ago says little, and the matrices grow with the parts squared."""
NOBODY: Final = ("\x00", "\x01")
"""Part types, or settings, that no part has."""

IN_ALL: Final = ("nose_mm", "wear_mm", "setting_mm", "walk_mm", "finish_mm", "finish_type_mm")
"""What a finish cut shares with other parts of its edge, setting and type."""


@by_content
@dataclass(frozen=True)
class Learned:
    """One term at n contact angles: mean (n,) and standard uncertainty (n,), mm; without the scatter of a cut."""

    mean_mm: Array
    u_mm: Array


@by_content
@dataclass(frozen=True)
class Behind:
    """The m errors behind the curves: of which part, whether of its finish cut, at which contact angle (m,).

    `left_mm` (m,) is what all terms together leave of each, mm: added to a curve, it shows how the parts scatter
    about it.
    """

    serial: tuple[str, ...]
    part_type: tuple[str, ...]
    finish: Flags
    contact_angle_rad: Array
    left_mm: Array


@by_content
@dataclass(frozen=True)
class Learnt:
    """What is known of an edge at n contact angles (n,), as it is after the last of its parts. Errors in mm, positive
    where material is left on.

    `form` is w(φ) with its wear; `transfer` is d(φ), the finish cut's error less the semi-finish cut's. `setting_mm`
    (2,) is o of the present setting along x (a radius) and z, with `setting_u_mm` (2,): at an angle it adds
    o·(sin φ, cos φ). `by_type`: what the finish cut of a part type has besides, by its name. `in_all` is the sum of all
    of them, by part type: the finish error of a next part in the present setting, had nothing been corrected. It is
    known better than its terms, which share offsets. `nearest_rad` (n,) is how far the nearest angle is that was
    touched or inspected. `form_at_mm`, `transfer_at_mm` and `in_all_at_mm` (m,) are the curves at the angles of
    `behind`; `parts` are those behind, `inspected` those with a finish inspection.
    """

    contact_angle_rad: Array
    form: Learned
    transfer: Learned
    setting_mm: Array
    setting_u_mm: Array
    by_type: Mapping[str, Learned]
    in_all: Mapping[str, Learned]
    nearest_rad: Array
    behind: Behind
    form_at_mm: Array
    transfer_at_mm: Array
    in_all_at_mm: Array
    parts: int
    inspected: int


def learnt(history: Sequence[MadePart], contact_angle_rad: Array) -> Learnt | None:
    """The terms of the model, given the parts in cutting order, at contact angles (n,) in rad; None without any error.

    Half of an offset's variance goes with the setting, half with the part type: a constant offset of the only part type
    is therefore shared between them. Valid for arcs, as the model is.
    """
    parts = list(history[-LATEST:])
    seen = observations(parts) if parts else None
    if seen is None or len(seen.error_mm) == 0:
        return None
    # Parts of no touches: the edge as it is now on parts of no known type, and each type in settings of its own; two
    # of each, which have nothing in common besides.
    bare, types = _bare(parts[-1]), list(dict.fromkeys(part.part_type for part in parts))
    now = [replace(bare, part_type=nobody) for nobody in NOBODY]
    others = [replace(bare, part_type=name, setting=nobody) for name in types for nobody in NOBODY]
    next_parts = [replace(bare, part_type=name) for name in types for _ in NOBODY]
    given = _Given(seen, [*parts, *now, *others, *next_parts], sizes(parts))
    at, k = contact_angle_rad, 2 * len(parts)

    def transfer(angle: Array) -> Learned:
        return given.of(("finish_mm",), k + 1, angle)

    def form(angle: Array) -> Learned:
        return given.of(("nose_mm", "wear_mm"), k, angle)

    def in_all(place: int, angle: Array) -> Learned:
        return given.of(IN_ALL, k + 4 * (len(types) + 1 + place) + 1, angle)

    # At 90° an offset is its x, at 0 its z.
    setting = given.of(("setting_mm", "walk_mm"), k, np.array([np.pi / 2, 0.0]))
    adds = {
        name: given.of(("setting_mm", "finish_type_mm"), k + 4 * place + 1, at) for place, name in enumerate(types, 1)
    }
    behind = _behind(parts, seen, given)
    return Learnt(
        contact_angle_rad=at,
        form=form(at),
        transfer=transfer(at),
        setting_mm=setting.mean_mm,
        setting_u_mm=setting.u_mm,
        by_type=adds,
        in_all={name: in_all(place, at) for place, name in enumerate(types)},
        nearest_rad=np.min(np.abs(np.subtract.outer(at, seen.contact_angle_rad)), axis=1),
        behind=behind,
        form_at_mm=form(seen.contact_angle_rad).mean_mm,
        transfer_at_mm=transfer(seen.contact_angle_rad).mean_mm,
        in_all_at_mm=_of_own_type(
            behind, [in_all(place, seen.contact_angle_rad).mean_mm for place in range(len(types))], types
        ),
        parts=len(parts),
        inspected=sum(part.uncorrected_mm is not None for part in parts),
    )


class _Given:
    """The errors seen, and the terms between their cuts and those asked about."""

    def __init__(self, seen: Observations, parts: Sequence[MadePart], size: Hyperparameters) -> None:
        from scipy.linalg import cho_factor

        self._seen, self._size = seen, size
        self._terms = terms(cuts_of(parts))
        self._factor = cho_factor(joint(seen, size).covariance[:-1, :-1], lower=True, check_finite=False)
        self.alpha = self._solved(seen.error_mm)

    def of(self, names: Sequence[str], cut: int, angle_rad: Array) -> Learned:
        """Terms together, as two cuts share them that are alike in them alone: `cut` and that of the next part."""
        across = self._covariance(
            names, cut, self._seen.cut, np.subtract.outer(angle_rad, self._seen.contact_angle_rad)
        )
        alone = self._covariance(names, cut, np.array([cut + 2]), np.zeros((len(angle_rad), 1)))[:, 0]
        variance = alone - np.sum(across.T * self._solved(across.T), axis=0)
        return Learned(across @ self.alpha, np.sqrt(np.maximum(variance, 0.0)))

    @property
    def left_mm(self) -> Array:
        """What all terms leave of the errors: their own variance of K⁻¹ y."""
        own = self._size["noise_mm"] ** 2 + self._seen.standard_u_mm**2
        return np.asarray(own * self.alpha)

    def _covariance(self, names: Sequence[str], cut: int, others: np.ndarray, difference: Array) -> Array:
        chosen = tuple(term for term in self._terms if term.size in names)
        shared, along = between_cuts(chosen, self._size), along_angle(difference, self._size)
        return np.asarray(sum(shared[goes][cut, others] * along[goes] for goes in along))

    def _solved(self, values: Array) -> Array:
        from scipy.linalg import cho_solve

        return np.asarray(cho_solve(self._factor, values, check_finite=False))


def _bare(part: MadePart) -> MadePart:
    return replace(part, semifinish=ArcErrors.none(), finish=None, correction_mm=None, from_memory_mm=None)


def _behind(parts: Sequence[MadePart], seen: Observations, given: _Given) -> Behind:
    of_part = seen.cuts.part[seen.cut]
    return Behind(
        tuple(parts[k].serial for k in of_part),
        tuple(parts[k].part_type for k in of_part),
        seen.cuts.finish[seen.cut] > 0,
        seen.contact_angle_rad,
        given.left_mm,
    )


def _of_own_type(behind: Behind, by_type: Sequence[Array], types: Sequence[str]) -> Array:
    """Of values by type, those of each error's own."""
    return np.stack(by_type)[[types.index(name) for name in behind.part_type], np.arange(len(behind.part_type))]
