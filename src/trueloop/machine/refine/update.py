"""A machine's model refined from its residuals on many parts [4773 §3.4], its own covariance being the prior.

Where parts were cut with COMP_MTG = −E_model, what is left along the normal is n · (E − E_model): to first order
n · D · x, x being what the coefficients lack. So the coefficients move by the posterior mean of

    residual = n · D · x + set-up of the part + what no form of the model has at this place + noise

with x ~ N(0, c² · covariance of the model + freedom of the guilty errors), c and the freedom as the evidence asks. The
gain of this update is the weight of [4773 §2.5]: little where the model is known well or the parts scatter, nearly 1
where neither holds. Time constants of lags are considered and not moved (Schmidt 1966): their uncertainty stays,
correlations with them count.
It holds to first order, with the guilty errors named rightly; its worth is judged by parts left out (`refine.py`).

Values as a sum of blocks of columns with normal coefficients: sizes by evidence, outliers counting less.

    y = Σ_b scale_b · rows_b · z_b + noise,    z_b ~ N(0, 1),   noise ~ σ · t_6

The sizes that the data ask for are those of greatest marginal likelihood on a grid. The noise has heavy tails, so
that a point far off loses its weight (6 + 1) / (6 + r²/σ²) (Lange, Little & Taylor 1989).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from trueloop.arrays import Array, Flags, Integers
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.names import ErrorName
from trueloop.machine.refine.guilty import Guilty, freedom, with_guilty
from trueloop.machine.refine.left import LeftOnParts, require_usable
from trueloop.units import UM_PER_MM

FREEDOM: Final = 6.0
ROUNDS: Final = 4
SWEEPS: Final = 8
OUTLIER: Final = 5.0
NOISE_LN: Final = 0.7
"""The uncertainty of the noise beforehand: standard deviation of its logarithm."""


@dataclass(frozen=True)
class Block:
    """Columns (n, k) with the scales that are tried of their coefficients; one scale is not sought."""

    rows: Array
    tried: tuple[float, ...] = (1.0,)


@dataclass(frozen=True)
class Mixed:
    """The result: scale of each block, standard deviation of the noise, posterior of all z in the blocks' order.

    `fisher` (q, q) is the information of the values alone on z. `outlier` (n,) are values more than five deviations
    off.
    """

    scales: Mapping[str, float]
    noise: float
    mean: Mapping[str, Array]
    covariance: Array
    fisher: Array
    outlier: Flags


def mixed(values: Array, blocks: Mapping[str, Block], weight: Array, noise: float, start: Mixed | None = None) -> Mixed:
    """Fits values (n,) whose noise is expected to be `noise`; a value of weight 1/2 counts as half a value.

    All lengths are in the same unit. `start` is an earlier fit of the same blocks from which the sizes are sought.
    """
    rows = np.hstack([np.zeros((len(values), 0)), *(block.rows for block in blocks.values())])
    own = np.repeat(np.arange(len(blocks)), [block.rows.shape[1] for block in blocks.values()])
    grids = [block.tried for block in blocks.values()] + [tuple(noise * 2.0 ** np.arange(-3, 4.5, 0.5))]
    at = [len(grid) // 2 for grid in grids]
    if start is not None:
        known = [*(start.scales[name] for name in blocks), start.noise]
        at = [int(np.argmin(np.abs(np.asarray(grid) - k))) for grid, k in zip(grids, known, strict=True)]
    tail = np.ones(len(values))
    for _ in range(ROUNDS if start is None else 2):
        gram = _Gram(rows, values, weight * tail, float(weight.sum()), noise)
        at = _climbed(gram, own, grids, at)
        sizes = [grid[k] for grid, k in zip(grids, at, strict=True)]
        scale, sigma = np.asarray(sizes[:-1])[own], sizes[-1]
        fisher = gram.normal * np.outer(scale, scale) / sigma**2
        covariance = np.linalg.inv(np.eye(len(scale)) + fisher)
        z = covariance @ (scale * gram.right) / sigma**2
        scaled = rows * scale
        rest = values - scaled @ z
        squares = rest**2 + np.einsum("nj,jk,nk->n", scaled, covariance, scaled)
        tail = (FREEDOM + 1) / (FREEDOM + squares / sigma**2)
    ends = np.cumsum([0, *(block.rows.shape[1] for block in blocks.values())])
    mean = {name: z[a:b] for name, a, b in zip(blocks, ends, ends[1:], strict=False)}
    found = dict(zip(blocks, sizes[:-1], strict=True))
    return Mixed(found, sigma, mean, covariance, fisher, np.abs(rest) > OUTLIER * sigma)


class _Gram:
    """The sums of rows and values that the evidence needs, once for all sizes."""

    def __init__(self, rows: Array, values: Array, weight: Array, count: float, noise: float) -> None:
        self.normal = rows.T @ (rows * weight[:, None])
        self.right = rows.T @ (weight * values)
        self.squares = float(values @ (weight * values))
        self.count, self.noise = count, noise

    def log_evidence(self, scale: Array, sigma: float) -> float:
        used = scale > 0
        scale = scale[used]
        whole = np.eye(len(scale)) + self.normal[np.ix_(used, used)] * np.outer(scale, scale) / sigma**2
        lower = cholesky(whole, lower=True, check_finite=False)
        inside = solve_triangular(lower, scale * self.right[used] / sigma**2, lower=True, check_finite=False)
        explained = self.squares / sigma**2 - float(inside @ inside)
        expected = (np.log(sigma / self.noise) / NOISE_LN) ** 2
        return -float(np.log(np.diag(lower)).sum() + self.count * np.log(sigma) + 0.5 * (explained + expected))


def _climbed(gram: _Gram, own: Integers, grids: Sequence[tuple[float, ...]], at: Sequence[int]) -> list[int]:
    """Indices in the grids of greatest evidence, from `at` on: each size in turn, to its neighbours or the least."""
    at, known = list(at), dict[tuple[int, ...], float]()

    def evidence(tried: list[int]) -> float:
        key = tuple(tried)
        if key not in known:
            sizes = [grid[k] for grid, k in zip(grids, tried, strict=True)]
            known[key] = gram.log_evidence(np.asarray(sizes[:-1])[own], sizes[-1])
        return known[key]

    for _ in range(SWEEPS):
        before = list(at)
        for k, grid in enumerate(grids):
            near = sorted({0, *range(max(at[k] - 1, 0), min(at[k] + 2, len(grid)))})
            at[k] = near[int(np.argmax([evidence([*at[:k], j, *at[k + 1 :]]) for j in near]))]
        if at == before:
            break
    return at


SIZES = (0.0, *(2.0**k * 1e-3 for k in np.arange(-2, 7)))
"""RMS in mm along the normals of what a guilty error may lack, a set-up or a place may leave: what is tried."""
WIDER = (1.0, 2.0, 4.0, 8.0, 16.0)
"""The factors by which the standard uncertainty of all coefficients may be too small: readings of a fit know nothing of
its form."""
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
    fit: Mixed


def guilty_ones(given: Sequence[ErrorName | Guilty]) -> tuple[Guilty, ...]:
    """Axis errors by name alone, or with the signal that each follows."""
    return tuple(one if isinstance(one, Guilty) else Guilty(one) for one in given)


def update(
    model: MachineModel,
    seen: LeftOnParts,
    guilty: Sequence[ErrorName | Guilty],
    *,
    share: float = 1.0,
    start: Mixed | None = None,
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
    blocks = {name: Block(along @ move, WIDER if name == MODEL else SIZES) for name, move in moves.items()}
    blocks |= {SET_UP: _in_um(seen.set_ups()), PLACE: _in_um(seen.places())}
    fit = mixed(seen.residual_mm * UM_PER_MM, blocks, seen.weights, seen.u_mm * UM_PER_MM, start)
    to_all = np.hstack([fit.scales[name] * move for name, move in moves.items()])
    refined = _moved(grown, to_all, fit, share)
    sizes = {name: fit.scales[name] for name in moves if name != MODEL}
    set_up, place = fit.scales[SET_UP], fit.scales[PLACE] if blocks[PLACE].rows.size else 0.0
    return Updated(refined, fit.outlier, fit.noise / UM_PER_MM, set_up, place, sizes, fit.scales[MODEL], fit)


def _in_um(rows: Array) -> Block:
    return Block(rows * UM_PER_MM, SIZES)


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
