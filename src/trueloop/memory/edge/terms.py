"""The model's terms: what two cuts share, times how that goes with contact angle.

    S_k = w(φ) + wear_k(φ) + o_k·(sin φ, cos φ) + g_k(φ) + ε_S       touches after the semi-finish cut
    E_k = S_k − ε_S + d(φ) + d_type(φ) + d_k(φ) + ε_F                 finish error had nothing been corrected

Every term is Gaussian, so that the model is its covariance: a sum of terms, each what two cuts share, M, times how that
goes with contact angle. A form has a Matérn covariance of order 5/2 over contact angle: two derivatives and no more, as
a nose has that wears in facets. An offset has sin φ sin φ′ + cos φ cos φ′ = cos(φ − φ′). Forms of the edge and of what
the finish cut does differently change over angles of their own. The walk and the wear are random walks, of covariance
min(t, t′).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.memory.edge.hyperparameters import Hyperparameters
from trueloop.memory.edge.observations import Cuts

OFFSET: Final = "offset"
FORMS: Final = ("angle_rad", "finish_angle_rad")
"""How a term goes with contact angle: as an offset, or as a form that changes over one of these angles."""


@dataclass(frozen=True)
class Term:
    """One term of unit size: `size` names its hyperparameter, `goes` how it goes with angle, `shared` is M (m, m)."""

    size: str
    goes: str
    shared: Array


def terms(cuts: Cuts) -> tuple[Term, ...]:
    """All terms between m cuts.

    Half of an offset's variance goes with the setting of the tool, half with the part type: which of them is not known.
    """
    part, part_type, setting = (_same(ids) for ids in (cuts.part, cuts.part_type, cuts.setting))
    finish = np.outer(cuts.finish, cuts.finish)
    edge_form, finish_form = FORMS
    return (
        Term("nose_mm", edge_form, np.ones_like(part)),
        Term("wear_mm", edge_form, np.minimum.outer(cuts.in_cut, cuts.in_cut)),
        Term("part_mm", edge_form, part),
        Term("setting_mm", OFFSET, (setting + part_type) / 2),
        Term("walk_mm", OFFSET, setting * np.minimum.outer(cuts.since_setting, cuts.since_setting)),
        Term("clamping_mm", OFFSET, part),
        Term("finish_mm", finish_form, finish),
        Term("finish_mm", OFFSET, finish),
        Term("finish_type_mm", finish_form, finish * part_type),
        Term("finish_type_mm", OFFSET, finish * part_type),
        Term("finish_part_mm", finish_form, finish * part),
        Term("finish_part_mm", OFFSET, finish * part),
    )


def between_cuts(all_terms: tuple[Term, ...], size: Hyperparameters) -> dict[str, Array]:
    """Covariance between cuts (m, m), mm², by how it goes with contact angle."""
    total = {goes: np.zeros_like(all_terms[0].shared) for goes in (OFFSET, *FORMS)}
    for term in all_terms:
        total[term.goes] += size[term.size] ** 2 * term.shared
    return total


def along_angle(difference_rad: Array, size: Hyperparameters) -> Mapping[str, Array]:
    """Covariance of unit variance over differences of contact angle, by how it goes."""
    return {OFFSET: np.cos(difference_rad), **{form: matern(difference_rad, size[form]) for form in FORMS}}


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
