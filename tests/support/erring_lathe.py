"""A lathe whose errors are known twice: as a formula typed here, and as a model that `machine/` evaluates."""

from collections.abc import Mapping

import numpy as np

from tests.support.machines import chain_with_travel
from trueloop.arrays import Array
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import CONSTANT, Part, Term, segments

CHAIN = chain_with_travel("turning")
X_TRAVEL, Z_TRAVEL = CHAIN.axis("X").travel, CHAIN.axis("Z").travel


def error_mm(x_mm: Array, z_mm: Array, t1_degc: float) -> Array:
    """E at axis positions, (n, 2) in (x, z): curved along z, inclined along x, growing with T1."""
    z, warmer = (z_mm + 150.0) / 100.0, t1_degc - 20.0
    on_x = 0.020 * z + 0.060 * z**2 + 0.0015 * warmer
    on_z = -0.010 * (x_mm - 100.0) / 100.0 - 0.0010 * warmer
    return np.column_stack([on_x, on_z])


def model() -> MachineModel:
    """The same as a machine model in terms of ISO 230-1."""
    z, x = segments(*Z_TRAVEL, 1, 2), segments(*X_TRAVEL, 1, 1)
    terms = (
        Term(error_name("EXZ"), (Part(z), Part(CONSTANT, "T1", 20.0))),
        Term(error_name("EZX"), (Part(x), Part(CONSTANT, "T1", 20.0))),
    )
    at_z, at_x = np.linspace(*Z_TRAVEL, 9), np.linspace(*X_TRAVEL, 9)
    on_x = np.linalg.lstsq(z.design(at_z), error_mm(0 * at_z, at_z, 20.0)[:, 0], rcond=None)[0]
    on_z = np.linalg.lstsq(x.design(at_x), error_mm(at_x, 0 * at_x, 20.0)[:, 1], rcond=None)[0]
    coefficients = np.concatenate([on_x, [0.0015], on_z, [-0.0010]])
    known: Mapping[str, tuple[float, float]] = {"T1": (15.0, 30.0)}
    return MachineModel(
        Machine("erring lathe", CHAIN, "7"), terms, coefficients, 1e-12 * np.eye(len(coefficients)), known
    )
