"""A term of the error, and the catalogue of all terms with the priors of their sizes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.estimate.places import Places

Sizes: TypeAlias = Mapping[str, float]
"""Hyperparameters by name: standard deviations in mm (of a taper in mm per mm), lengths in rad or as shares."""

PART: Final = "part"
"""The label that a term of one part alone has in its scope."""


@dataclass(frozen=True)
class Prior:
    """A log-normal prior of a size: its median, the standard deviation of its logarithm, and where both come from."""

    median: float
    log_sd: float
    source: str


@dataclass(frozen=True)
class Term:
    """Basis functions of the place times coefficients.

    `scope`: the columns of a place whose values say whose coefficients these are; () for one set of all. `basis` maps
    n places to (n, m); `spread` maps sizes to the standard deviations (m,) of the coefficients before anything was
    measured, which may be zero. `step`: standard deviations of the random walk by one unit of the column `clock`; None:
    the coefficients are constant. `tail`: coefficients of each scope have Student's distribution with so many degrees
    of freedom, one scale for all of a scope, so that one feature of one part may be far off; None: normal ones.
    """

    name: str
    scope: tuple[str, ...]
    basis: Callable[[Places], Array]
    spread: Callable[[Sizes], Array]
    step: Callable[[Sizes], Array] | None = None
    clock: str = "order"
    tail: float | None = None

    @property
    def of_part(self) -> bool:
        """Returns whether its coefficients are of one part alone."""
        return PART in self.scope


@dataclass(frozen=True, eq=False)
class Catalogue:
    """Terms, the repeatability variance of a cut at places (n,), and the priors of all sizes that both use.

    `gross`: the share of touches that are gross errors, by standard deviations `gross_factor` times as large.
    """

    terms: tuple[Term, ...]
    repeatability_mm2: Callable[[Places, Sizes], Array]
    priors: Mapping[str, Prior]
    gross: float = 0.01
    gross_factor: float = 15.0

    @property
    def medians(self) -> dict[str, float]:
        """Returns the priors' medians: the sizes before any part was measured."""
        return {name: prior.median for name, prior in self.priors.items()}

    def sizes(self, logarithms: Array) -> dict[str, float]:
        """Sizes from their logarithms, in the order of `priors`."""
        return dict(zip(self.priors, np.exp(logarithms).tolist(), strict=True))

    def logarithms(self, sizes: Sizes) -> Array:
        """Returns the logarithms of sizes, the reverse of `sizes`, (k,)."""
        return np.log([sizes[name] for name in self.priors])
