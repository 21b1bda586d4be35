"""Which error of which axis the machine's model gets wrong, from what it left on many parts [4773 §3.3, Table 1].

The residuals ERROR_MTG,RESID along the normals [6876 §3.5] are compared with what each axis error would leave if the
model had it wrong: its influence on the tool point at every gauging point (Table 1's δ, ε·Z_T, ε·X_T, ε·x follow from
it), times functions of its axis' position and of the temperature of the element that carries it. A term that is wrong
leaves n · E, positive where it leaves material on. Every part may be set up elsewhere.

Hypotheses are: nothing, one error, two. Each has a marginal likelihood, so that a hypothesis with more parameters has
to earn them, and probabilities follow. Errors that one tool, one place or equal temperatures cannot tell apart share
the probability: the answer is a set, and never one name out of a set.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers, by_content
from trueloop.diagnosis.evidence import SIZES, evidence, shares
from trueloop.machine.model.chain import Chain
from trueloop.machine.model.model import State, design
from trueloop.machine.model.names import ErrorName
from trueloop.machine.model.position_basis import CONSTANT, PositionBasis
from trueloop.machine.model.term import Part, Term

NOISE_MM: Final = 0.001
"""What residuals scatter by, to begin with: the prior of their variance is worth two of them."""
SETTING: Final = (0.1, 1.0, 4.0, 15.0, 60.0)
"""Variances of a part's set-up, in variances of the noise: what is tried."""
NOTHING_WRONG: Final = 0.9
ONE_WRONG: Final = 0.09
"""Beforehand. Two errors have the rest."""
OTHER_ELEMENT: Final = 0.1
"""How probable another element's temperature is beside that of the error's own: "other correlations" of [4773 §3.3]."""


@by_content
@dataclass(frozen=True)
class Residuals:
    """What the machine's model left at n gauging points of many parts: `residual_mm` (n,) along the normals (n, 3).

    `part` (n,) numbers the parts, `state` is the machine in each point while it was cut. `element` names the signal
    that is the temperature of each axis' element.
    """

    part: Integers
    normal: Array
    state: State
    residual_mm: Array
    element: Mapping[str, str]


@dataclass(frozen=True)
class Suspect:
    """An axis error with the temperature that it may follow."""

    error: ErrorName
    signal: str

    def __str__(self) -> str:
        return f"{self.error} with {self.signal}"


@dataclass(frozen=True)
class Verdict:
    """Hypotheses with their probabilities, most probable first; () is that nothing is wrong."""

    hypotheses: tuple[tuple[tuple[Suspect, ...], float], ...]
    by_error: Mapping[ErrorName, float] = field(default_factory=dict)

    @property
    def sound(self) -> float:
        """Probability that no error is wrong by as much as the residuals could show."""
        return dict(self.hypotheses).get((), 0.0)

    def credible(self, level: float = 0.995) -> tuple[tuple[Suspect, ...], ...]:
        """The fewest hypotheses that hold the truth with that probability."""
        total, found = 0.0, []
        for hypothesis, probability in self.hypotheses:
            found.append(hypothesis)
            total += probability
            if total >= level:
                break
        return tuple(found)


def suspects(chain: Chain, element: Mapping[str, str]) -> list[tuple[Suspect, float]]:
    """Errors of motion of the linear axes and of place of the spindles, with their share of the prior."""
    signals = sorted(set(element.values()))
    found = []
    for name in chain.errors():
        linear = name.axis in chain.order
        if name.axis in element and linear != name.place:
            for signal in signals:
                own = signal == element[name.axis]
                found.append((Suspect(name, signal), 1.0 if own else OTHER_ELEMENT / max(len(signals) - 1, 1)))
    return found


def columns(chain: Chain, suspect: Suspect, seen: Residuals) -> Array:
    """What it would leave along the normals, (n, k), each of the size 1 at most of the points."""
    state = seen.state
    temperature = np.broadcast_to(np.asarray(state.signals[suspect.signal], np.float64), seen.residual_mm.shape)
    reference = float(temperature.mean())
    parts = [Part(CONSTANT), Part(CONSTANT, suspect.signal, reference)]
    if suspect.error.axis in chain.order:
        at = state.positions[:, chain.order.index(suspect.error.axis)]
        low, high = float(at.min()), float(at.max())
        if high > low:
            curve, line = PositionBasis((low, high), 2), PositionBasis((low, high), 1)
            parts = [Part(curve), Part(line, suspect.signal, reference)]
    rows = design(chain, (Term(suspect.error, tuple(parts)),), state)
    along = np.einsum("ni,nik->nk", seen.normal, rows)
    scale = np.sqrt(np.mean(along**2, axis=0))
    unit: Array = along[:, scale > 0.0] / scale[scale > 0.0]
    return unit


def judge(chain: Chain, seen: Residuals, pairs: bool = True) -> Verdict:
    """Probabilities of what is wrong. With `pairs` two errors at once are looked for among the ten likeliest."""
    asked = suspects(chain, seen.element)
    whole = sum(share for _, share in asked)
    blocks = {one: columns(chain, one, seen) for one, _ in asked}
    log: dict[tuple[Suspect, ...], float] = {(): evidence_of(seen, []) + np.log(NOTHING_WRONG)}
    for one, share in asked:
        if blocks[one].shape[1]:
            log[(one,)] = evidence_of(seen, [blocks[one]]) + np.log(ONE_WRONG * share / whole)
    if pairs:
        likely = sorted((h for h in log if h), key=lambda h: -log[h])[:10]
        share_of = dict(asked)
        for (a,), (b,) in combinations(likely, 2):
            if a.error != b.error:
                prior = (1 - NOTHING_WRONG - ONE_WRONG) * 2 * share_of[a] * share_of[b] / whole**2
                log[(a, b)] = evidence_of(seen, [blocks[a], blocks[b]]) + np.log(prior)
    return _verdict(log)


def evidence_of(seen: Residuals, blocks: Sequence[Array]) -> float:
    """Logarithm of the marginal likelihood: set-up and wrong errors normal, the noise's variance unknown."""
    tried = [(_set_ups(seen), SETTING), *((block, SIZES) for block in blocks)]
    return evidence(seen.residual_mm / NOISE_MM, tried)


def _set_ups(seen: Residuals) -> Array:
    """How a part set up elsewhere shows along the normals: a column a part and direction."""
    numbers, place = np.unique(seen.part, return_inverse=True)
    rows = np.zeros((len(seen.residual_mm), len(numbers), 3))
    rows[np.arange(len(place)), place] = seen.normal
    flat = rows.reshape(len(place), -1)
    return flat[:, np.any(flat != 0.0, axis=0)]


def _verdict(log: Mapping[tuple[Suspect, ...], float]) -> Verdict:
    found = shares(log)
    by_error: dict[ErrorName, float] = {}
    for hypothesis, share in found.items():
        for one in hypothesis:
            by_error[one.error] = by_error.get(one.error, 0.0) + share
    return Verdict(tuple(found.items()), dict(sorted(by_error.items(), key=lambda item: -item[1])))
