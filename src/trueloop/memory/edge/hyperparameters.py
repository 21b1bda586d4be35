"""How large the model's terms are, and what was believed of them before any part: weak log-normal priors.

Stated from turning in general, before any measured part was held against them, and in agreement with
`turned.fit.between_cuts`: a setting by touch-off and a worn nose err by some tens of micrometres; a part clamped again,
a turret indexed and some minutes of heat move a cut by 2 µm; two cuts of different depth differ by some micrometres. A
log-normal prior's standard deviation of 1 allows for a factor of 7 either way (95 %), one of 0.5 for 2.7.
"""

from dataclasses import dataclass
from math import radians
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content


@dataclass(frozen=True)
class Prior:
    """One hyperparameter: the median of its log-normal prior and the standard deviation of its logarithm."""

    name: str
    median: float
    log_sd: float
    meaning: str


PRIORS: Final = (
    Prior("nose_mm", 0.020, 1.0, "w: form of the edge"),
    Prior("angle_rad", radians(25.0), 0.5, "over which contact angle the edge's form changes"),
    Prior("setting_mm", 0.020, 1.0, "o: setting of the tool and of the part type, along x and z each"),
    Prior("walk_mm", 0.001, 1.0, "o: random walk from part to part"),
    Prior("clamping_mm", 0.002, 0.5, "o: of one part, by clamping and heat"),
    Prior("wear_mm", 0.001, 1.0, "wear: form of the edge, from part to part"),
    Prior("part_mm", 0.0015, 0.5, "g: form of one part, alike in both cuts"),
    Prior("finish_mm", 0.005, 0.5, "d: of every finish cut against the semi-finish cut"),
    Prior("finish_type_mm", 0.001, 0.5, "d_type: the same, of a part type"),
    Prior("finish_part_mm", 0.002, 0.5, "d_k: the same, of one part"),
    Prior("finish_angle_rad", radians(25.0), 0.5, "over which contact angle d changes"),
    Prior("noise_mm", 0.0015, 0.5, "ε: scatter of a cut from place to place"),
)
NAMES: Final = tuple(prior.name for prior in PRIORS)
MEDIAN: Final = np.log([prior.median for prior in PRIORS])
LOG_SD: Final = np.array([prior.log_sd for prior in PRIORS])
GAIN_SD: Final = 0.3
"""Of what a wrong actuator makes of a correction of 1."""

WRONG: Final = 0.01
"""Share of actuators that were believed wrong beforehand: a diameter taken for a radius, a correction run twice."""

SUSPECT: Final = 0.2
"""Only a gain that seems to be off by more is asked about: one nearer to 1 cannot be separated from d(φ)."""

JITTER_MM2: Final = 1e-10
"""Added to every variance: (0.01 µm)². Keeps the covariance of coincident touches positive definite."""


@by_content
@dataclass(frozen=True)
class Hyperparameters:
    """Standard deviations of the terms, mm, and the angle over which forms change, rad: as logarithms (h,).

    `gain_sd` is that of the actuator's gain about 1: zero where a correction is made as commanded.
    """

    logarithm: Array
    gain_sd: float = 0.0

    def __getitem__(self, name: str) -> float:
        """One of them by its name in `PRIORS`."""
        return float(np.exp(self.logarithm[NAMES.index(name)]))


BEFOREHAND: Final = Hyperparameters(MEDIAN)
"""The medians of the priors."""


def log_prior(logarithm: Array) -> tuple[float, Array]:
    """Logarithm of the priors' density, up to a constant, and its gradient."""
    off = (logarithm - MEDIAN) / LOG_SD
    return -0.5 * float(off @ off), -off / LOG_SD
