"""The source's own way to name axis errors: one correlation after another [4773 §3.3, Table 1].

A row of Table 1 is a product: the influence of an axis error, the temperature of its element, and for an error of
motion the position of its axis too or not. The product that correlates best with the residuals names the error; what it
explains is taken out, and the next is looked for. It names one error where the data cannot tell several
apart, and what looks alike to what was taken out is never seen: it is shown for comparison.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.terms.columns import raw
from trueloop.diagnosis.terms.residuals import Residuals
from trueloop.machine.model.chain import Chain
from trueloop.machine.model.position_basis import CONSTANT
from trueloop.machine.model.term import Part

LEAST: Final = 0.2
"""Below this correlation nothing is named."""
STEPS: Final = 3


@dataclass(frozen=True)
class Correlation:
    """One step: the error named, the signal that it follows, and the correlation with what was left till then."""

    error: str
    signal: str
    correlation: float


def one_after_another(chain: Chain, seen: Residuals) -> tuple[Correlation, ...]:
    """At most three steps, the largest correlation of each; () where none reaches 0.2."""
    products, left, found = list(_products(chain, seen)), seen.residual_mm - seen.residual_mm.mean(), []
    for _ in range(STEPS):
        best = max(products, key=lambda one: abs(_correlation(left, one[2])), default=None)
        if best is None or abs(_correlation(left, best[2])) < LEAST:
            break
        error, signal, rows = best
        found.append(Correlation(error, signal, _correlation(left, rows)))
        left = left - rows * float(rows @ left) / float(rows @ rows)
    return tuple(found)


def _products(chain: Chain, seen: Residuals) -> Iterator[tuple[str, str, Array]]:
    """Error, signal and product, its mean taken out."""
    for name in chain.errors():
        signal = seen.element.get(name.axis, "")
        if signal not in seen.state.signals or (name.axis in chain.order) == name.place:
            continue
        warm = np.asarray(seen.state.signals[signal], np.float64)
        part = Part(CONSTANT, signal, float(warm.mean()))
        rows = raw(chain, name, (part,), False, seen.state, seen.normal)[:, 0]
        factors = [np.ones(len(rows))]
        if name.axis in chain.order:
            factors.append(seen.state.positions[:, chain.order.index(name.axis)])
        for factor in factors:
            product = rows * factor - float(np.mean(rows * factor))
            if float(np.abs(product).max()) > 0.0:
                yield str(name), signal, product


def _correlation(values: Array, product: Array) -> float:
    size = float(np.linalg.norm(values) * np.linalg.norm(product))
    return float(values @ product) / size if size > 0.0 else 0.0
