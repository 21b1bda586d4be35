"""Residuals made ready: columns of all suspects, set-ups, weights of points, and how well hypotheses explain them.

Every part may be set up elsewhere: that is taken out of columns and values once, for all hypotheses.

A turned part lies on the measuring machine closer across its axis, which is its datum, than along it: so the variances
of set-ups along X, Y and Z and of turns are tried apart. One for all makes much of what a few parts share by chance.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.diagnosis.terms.suspects import Columns, Residuals, Suspect, columns, suspects
from trueloop.estimate.weights import SIZES, log_student, tried
from trueloop.machine.model.chain import Chain
from trueloop.machine.model.kinematics import tool_in_work_mm

FINE: Final = (0.2, 2.0, 20.0, 300.0)
COARSE: Final = (0.3, 8.0, 200.0)
"""Variances of a part's set-up in one way, in variances of the noise: what is tried with up to two ways, with more."""
TURN: Final = 3
"""Ways are X, Y, Z and turns, these together."""


@dataclass(frozen=True)
class SetUps:
    """How parts set up elsewhere show along the normals: `rows` (n, columns), `way` (columns,) of each, 0 to `TURN`."""

    rows: Array
    way: Integers

    @property
    def tried(self) -> Array:
        """Variances that are tried, (settings, TURN + 1); 0 in ways in which nothing shows."""
        present = sorted({int(way) for way in self.way})
        grid = FINE if len(present) <= 2 else COARSE
        found = np.zeros((len(grid) ** len(present), TURN + 1))
        found[:, present] = list(product(grid, repeat=len(present)))
        return found


def set_ups(part: Integers, normal: Array, place_mm: Array | None = None) -> SetUps:
    """A column a part and way to move it; with places (n, 3) to turn it too, by 1 at the points' mean distance."""
    moved = [normal]
    if place_mm is not None:
        arms = place_mm - place_mm.mean(axis=0)
        moved.append(np.cross(arms, normal) / max(float(np.sqrt(np.mean(np.sum(arms**2, axis=1)))), 1e-9))
    ways = np.hstack(moved)
    numbers, where = np.unique(part, return_inverse=True)
    rows = np.zeros((len(part), len(numbers), ways.shape[1]))
    rows[np.arange(len(where)), where] = ways
    flat = rows.reshape(len(where), -1)
    way = np.tile(np.minimum(np.arange(ways.shape[1]), TURN), len(numbers))
    shows = np.any(np.abs(flat) > 1e-12, axis=0)
    return SetUps(flat[:, shows], way[shows])


@dataclass(frozen=True)
class TakenOut:
    """Products of columns and of values with set-ups of each setting taken out.

    `gram` (settings, k, k), `right` (settings, k), `squares` (settings,); `volume` (settings,) is −½ log det of what
    they add to the noise, `variances` (settings, ways) are theirs, `tried` is how many settings there were.
    """

    gram: Array
    right: Array
    squares: Array
    volume: Array
    count: int
    variances: Array
    tried: int

    def only(self, which: Flags) -> "TakenOut":
        """With some of the settings alone."""
        gram, right, squares, volume = self.gram[which], self.right[which], self.squares[which], self.volume[which]
        return TakenOut(
            gram=gram,
            right=right,
            squares=squares,
            volume=volume,
            count=self.count,
            variances=self.variances[which],
            tried=self.tried,
        )


def taken_out(set_up: SetUps, rows: Array, values: Array, scatter: Array) -> TakenOut:
    """Woodbury's identity, once a setting; everything is divided by `scatter` (n,)."""
    both, own_rows = np.hstack([rows, values[:, None]]) / scatter[:, None], set_up.rows / scatter[:, None]
    whole, across, own = both.T @ both, own_rows.T @ both, own_rows.T @ own_rows
    products, volumes = [], []
    for variances in set_up.tried:
        root = np.sqrt(variances[set_up.way])
        inside = np.eye(len(own)) + root[:, None] * own * root
        scaled = root[:, None] * across
        products.append(whole - scaled.T @ np.linalg.solve(inside, scaled))
        volumes.append(-0.5 * np.linalg.slogdet(inside)[1])
    left, volume = np.stack(products), np.array(volumes)
    return TakenOut(
        gram=left[:, :-1, :-1],
        right=left[:, :-1, -1],
        squares=left[:, -1, -1],
        volume=volume,
        count=len(values),
        variances=set_up.tried,
        tried=len(volume),
    )


Hypothesis = tuple[Suspect, ...]
NOISE_MM: Final = 0.001
"""The initial scatter of residuals: the prior of their variance is worth two of them."""
AT_ONCE: Final = 64
"""Hypotheses that are worked out at once: a matter of memory alone."""


@dataclass(frozen=True)
class Question:
    """`rows` (n, columns) of all parts of suspects, `place` of each among them; the last column is 0.

    `prior` has every suspect that would leave something, with its share. `set_up` are columns of set-ups. All is
    divided by the scatter of each point, `scatter` (n,) in units of `NOISE_MM`.
    """

    chain: Chain
    seen: Residuals
    prior: Mapping[Suspect, float]
    columns: Mapping[Suspect, Columns]
    place: Mapping[Suspect, slice]
    rows: Array
    set_up: SetUps
    scatter: Array

    @property
    def values(self) -> Array:
        """Residuals in units of their noise to begin with."""
        return self.seen.residual_mm / NOISE_MM

    def products(self) -> TakenOut:
        """Of rows and values, weighted."""
        return taken_out(self.set_up, self.rows, self.values, self.scatter)

    def index(self, hypothesis: Hypothesis, width: int) -> tuple[list[int], list[int]]:
        """Columns of a hypothesis filled up to `width` with the column that is 0, and whose each is."""
        found: list[int] = []
        of: list[int] = []
        for number, suspect in enumerate(hypothesis):
            for part in suspect.parts:
                where = range(self.rows.shape[1])[self.place[part]]
                found, of = found + list(where), of + [number] * len(where)
        missing = width - len(found)
        return found + [self.rows.shape[1] - 1] * missing, of + [0] * missing

    def count(self, hypothesis: Hypothesis) -> int:
        """Returns the number of columns."""
        return sum(self.place[part].stop - self.place[part].start for suspect in hypothesis for part in suspect.parts)


def question(chain: Chain, residuals: Residuals, *, turned: bool = False) -> Question:
    """Of residuals that have the order of parts as a signal. With `turned` frames of parts may be turned too."""
    prior = dict(suspects(chain, residuals))
    shapes = {
        part: columns(chain, part, residuals) for part in dict.fromkeys(p for suspect in prior for p in suspect.parts)
    }
    found = {part: shape for part, shape in shapes.items() if shape is not None}
    ends = np.cumsum([0, *(shape.mixing.shape[1] for shape in found.values())])
    place = {part: slice(int(a), int(b)) for part, a, b in zip(found, ends, ends[1:], strict=False)}
    rows = [shape.rows(chain, residuals.state, residuals.normal) for shape in found.values()]
    points = tool_in_work_mm(chain, residuals.state.positions, residuals.state.tool_mm) if turned else None
    possible = {suspect: share for suspect, share in prior.items() if all(part in found for part in suspect.parts)}
    zero = np.zeros((len(residuals.part), 1))
    set_up = set_ups(residuals.part, residuals.normal, points)
    return Question(
        chain=chain,
        seen=residuals,
        prior=possible,
        columns=found,
        place=place,
        rows=np.hstack([*rows, zero]),
        set_up=set_up,
        scatter=np.ones(len(zero)),
    )


def log_evidence(question: Question, products: TakenOut, hypotheses: Sequence[Hypothesis]) -> Array:
    """Logarithms of the marginal likelihood of hypotheses with equally many suspects, (hypotheses,)."""
    parts = [hypotheses[k : k + AT_ONCE] for k in range(0, len(hypotheses), AT_ONCE)]
    grids = [log_grid(question, products, part) for part in parts]
    count = products.tried * len(SIZES) ** max(len(hypotheses[0]), 1)
    log = np.concatenate([grid.reshape(len(grid), -1) for grid in grids])
    return np.asarray(np.logaddexp.reduce(log, axis=1) - np.log(count))


def log_grid(question: Question, products: TakenOut, hypotheses: Sequence[Hypothesis]) -> Array:
    """By hypothesis, variance of set-ups and sizes of suspects, (hypotheses, settings, sizes ** suspects)."""
    width = max(question.count(hypothesis) for hypothesis in hypotheses)
    pairs = [question.index(hypothesis, width) for hypothesis in hypotheses]
    index, of = np.array([p[0] for p in pairs], int), np.array([p[1] for p in pairs], int)
    gram = products.gram[:, index[:, :, None], index[:, None, :]].swapaxes(0, 1)[:, :, None]
    right = products.right[:, index].swapaxes(0, 1)[:, :, None]
    sizes = [SIZES] * max(len(hypotheses[0]), 1)
    variances = tried(sizes, of.reshape(len(pairs), width)).swapaxes(0, 1)[:, None]
    logs = log_student(gram, right, products.squares[None, :, None], products.count, variances)
    found: Array = logs + products.volume[None, :, None]
    return found


@dataclass(frozen=True)
class Posterior:
    """Coefficients of the columns of a hypothesis, `mean` (k,) and `covariance` (k, k), units of `NOISE_MM`.

    `noise` is the variance of one value, `setting` (ways,) those of set-ups, `left` (n,) what is not explained.
    """

    hypothesis: Hypothesis
    mean: Array
    covariance: Array
    noise: float
    setting: Array
    left: Array


def posterior(question: Question, products: TakenOut, hypothesis: Hypothesis) -> Posterior:
    """At the likeliest sizes."""
    grid = log_grid(question, products, [hypothesis])[0]
    setting, sizes = np.unravel_index(int(np.argmax(grid)), grid.shape)
    index, of = question.index(hypothesis, question.count(hypothesis))
    own = tried([SIZES] * max(len(hypothesis), 1), np.array(of, int))[int(sizes)]
    rows = np.hstack([question.rows[:, index], question.set_up.rows])
    set_up = products.variances[int(setting)]
    before = np.array([*own, *set_up[question.set_up.way]])
    weighted = rows / question.scatter[:, None]
    spread: Array = np.asarray(np.linalg.inv(weighted.T @ weighted + np.diag(1 / before)), np.float64)
    mean = spread @ weighted.T @ (question.values / question.scatter)
    left = question.values - rows @ mean
    noise = (2.0 + float(np.sum((left / question.scatter) ** 2) + np.sum(mean**2 / before))) / (2.0 + len(left))
    k = len(index)
    return Posterior(
        hypothesis=hypothesis,
        mean=mean[:k],
        covariance=noise * spread[:k, :k],
        noise=noise,
        setting=noise * set_up,
        left=left,
    )
