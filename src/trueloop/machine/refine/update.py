"""A machine's model refined from its residuals on many parts [4773 §3.4], its own covariance being the prior.

Where parts were cut with COMP_MTG = −E_model, what is left along the normal is n · (E − E_model): to first order
n · D · x, x being what the coefficients lack. So the coefficients move by the posterior mean of

    residual = n · D · x + set-up of the part + what no form of the model has at this place + noise

with x ~ N(0, c² · covariance of the model + freedom of the guilty errors), c and the freedom as the evidence asks. The
gain of this update is the weight of [4773 §2.5]: little where the model is known well or the parts scatter, nearly 1
where neither holds. Time constants of lags are considered and not moved (Schmidt 1966): their uncertainty stays,
correlations with them count.
It holds to first order, with the guilty errors named rightly; its worth is judged by parts left out (`refine.py`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.estimate.blocks import Block, Mixed, mixed
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.names import ErrorName
from trueloop.machine.refine.guilty import Guilty, freedom, with_guilty
from trueloop.machine.refine.left import LeftOnParts, require_usable
from trueloop.units import UM_PER_MM

LEAST_MM, MOST_MM = 1e-5, 0.064
"""RMS along the normals of what a guilty error may lack, a set-up or a place may leave."""
WIDER = 16.0
"""The largest factor by which the standard uncertainty of all coefficients may be too small: readings of a fit know
nothing of its form."""
MODEL, SET_UP, PLACE = "model", "set-up", "place"


@dataclass(frozen=True)
class Updated:
    """The model with its coefficients moved, and the quantities of the update.

    `outlier` (n,) are points more than five standard deviations off, which hardly counted. `noise_mm`, `set_up_mm` and
    `place_mm` are standard deviations found: of a point, of a part's set-up, of what stays at a place whatever the
    coefficients are. `freedom_mm` is by how much each guilty error (and its signal) was let move, RMS of points;
    `wider` by what factor the standard uncertainties of all coefficients had to be larger than the model says.
    """

    model: MachineModel
    outlier: Flags
    noise_mm: float
    set_up_mm: float
    place_mm: float
    freedom_mm: Mapping[str, float]
    wider: float


def guilty_ones(given: Sequence[ErrorName | Guilty]) -> tuple[Guilty, ...]:
    """Axis errors by name alone, or with the signal that each follows."""
    return tuple(one if isinstance(one, Guilty) else Guilty(one) for one in given)


def update(
    model: MachineModel,
    seen: LeftOnParts,
    guilty: Sequence[ErrorName | Guilty],
    *,
    share: float = 1.0,
) -> Updated:
    """Updates the model by its residuals on the parts: its coefficients moved by `share` of the change [4773 §2.5].

    Raises DIA-FEW for fewer than three parts, MCH-SHAPE for points that do not belong together, MCH-AXIS for a guilty
    error that the machine does not have, MCH-SIGNAL where a temperature is not given.
    """
    require_usable(seen)
    named = guilty_ones(guilty)
    grown = replace(with_guilty(model, named, seen.state), version=None)
    along = np.einsum("ni,nij->nj", seen.normal, grown.sensitivities(seen.state)) * UM_PER_MM
    moves = {MODEL: _root(grown.covariance), **freedom(grown, named, seen)}
    blocks = {
        name: Block(along @ move, *((1.0, WIDER) if name == MODEL else (LEAST_MM, MOST_MM)))
        for name, move in moves.items()
    }
    blocks |= {SET_UP: _in_um(seen.set_ups()), PLACE: _in_um(seen.places())}
    fit = mixed(seen.residual_mm * UM_PER_MM, blocks, seen.weights, seen.u_mm * UM_PER_MM)
    to_all = np.hstack([fit.scales[name] * move for name, move in moves.items()])
    refined = _moved(grown, to_all, fit, share)
    sizes = {name: fit.scales[name] for name in moves if name != MODEL}
    set_up, place = fit.scales[SET_UP], fit.scales[PLACE] if blocks[PLACE].rows.size else 0.0
    return Updated(refined, fit.outlier, fit.noise / UM_PER_MM, set_up, place, sizes, fit.scales[MODEL])


def _in_um(rows: Array) -> Block:
    return Block(rows * UM_PER_MM, LEAST_MM, MOST_MM)


def _moved(model: MachineModel, to_all: Array, fit: Mixed, share: float) -> MachineModel:
    """Coefficients by the posterior mean; covariance of what is then unknown, lags considered and left where they are.

    With the gain G of z and M that leaves out lags and makes only a share of the change, the error of the change is
    (T − M T (I − V)) z − noise: V the posterior covariance of z, T from z to coefficients and lags (Joseph's form).
    """
    own = len(model.coefficients)
    made = np.zeros(len(to_all))
    made[:own] = share
    z = np.concatenate(list(fit.mean.values()))[: to_all.shape[1]]
    change = made * (to_all @ z)
    whole = np.hstack([to_all, np.zeros((len(to_all), len(fit.covariance) - to_all.shape[1]))])
    posterior = made[:, None] * (whole @ fit.covariance)
    missed = whole - made[:, None] * whole + posterior
    covariance = missed @ missed.T + posterior @ fit.fisher @ posterior.T
    return replace(model, coefficients=model.coefficients + change[:own], covariance=covariance)


def _root(covariance: Array) -> Array:
    """Columns whose products sum to the covariance, as many as it has directions."""
    scale = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    unit = np.where(scale > 0.0, scale, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    kept = values > 1e-12 * max(float(values.max(initial=0.0)), 1e-300)
    root: Array = unit[:, None] * vectors[:, kept] * np.sqrt(values[kept])
    return root
