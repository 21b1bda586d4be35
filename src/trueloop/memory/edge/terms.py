"""The model's terms: what two cuts share, times how that goes with contact angle.

    S_k = w(φ) + wear_k(φ) + o_k·(sin φ, cos φ) + g_k(φ) + ε_S       touches after the semi-finish cut
    E_k = S_k − ε_S + d(φ) + d_type(φ) + d_k(φ) + ε_F                 finish error had nothing been corrected

Every term is Gaussian, so that the model is its covariance. A form, w for example, has a Matérn covariance of order 5/2
over contact angle: two derivatives, no more, as a nose has that wears in facets. An offset has
sin φ sin φ′ + cos φ cos φ′ = cos(φ − φ′). All of it is

    cov = A ∘ matern(φ − φ′) + B ∘ cos(φ − φ′) + noise,

A and B between cuts, each the sum of the terms. The walk and the wear are random walks, of covariance min(t, t′).
"""

from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.memory.edge.hyperparameters import Hyperparameters
from trueloop.memory.edge.observations import Cuts


@dataclass(frozen=True)
class Term:
    """One term of unit size between m cuts and m′: `form` and `offset` (m, m′), None where it has none."""

    name: str
    form: Array | None = None
    offset: Array | None = None


def terms(cuts: Cuts) -> tuple[Term, ...]:
    """All terms, named by their hyperparameter, between cuts (m, m).

    Half of an offset's variance goes with the setting of the tool, half with the part type: which of them is not known.
    """
    part, part_type, setting = (_same(ids) for ids in (cuts.part, cuts.part_type, cuts.setting))
    finish = np.outer(cuts.finish, cuts.finish)
    return (
        Term("nose_mm", form=np.ones_like(part)),
        Term("wear_mm", form=np.minimum.outer(cuts.in_cut, cuts.in_cut)),
        Term("part_mm", form=part),
        Term("setting_mm", offset=(setting + part_type) / 2),
        Term("walk_mm", offset=setting * np.minimum.outer(cuts.since_setting, cuts.since_setting)),
        Term("clamping_mm", offset=part),
        Term("finish_mm", finish, finish),
        Term("finish_type_mm", finish * part_type, finish * part_type),
        Term("finish_part_mm", finish * part, finish * part),
    )


def between_cuts(all_terms: tuple[Term, ...], size: Hyperparameters) -> tuple[Array, Array]:
    """A of the forms and B of the offsets, (m, m), mm²."""
    form = sum(size[term.name] ** 2 * term.form for term in all_terms if term.form is not None)
    offset = sum(size[term.name] ** 2 * term.offset for term in all_terms if term.offset is not None)
    return np.asarray(form), np.asarray(offset)


def matern(difference_rad: Array, angle_rad: float) -> Array:
    """Matérn covariance of order 5/2 and unit variance; `angle_rad` is its length scale."""
    a = np.sqrt(5.0) * np.abs(difference_rad) / angle_rad
    return np.asarray((1.0 + a + a**2 / 3.0) * np.exp(-a))


def matern_by_log_angle(difference_rad: Array, angle_rad: float) -> Array:
    """Its derivative by the logarithm of `angle_rad`."""
    a = np.sqrt(5.0) * np.abs(difference_rad) / angle_rad
    return np.asarray(a**2 * (1.0 + a) / 3.0 * np.exp(-a))


def _same(ids: Integers) -> Array:
    return np.equal.outer(ids, ids).astype(np.float64)
