"""The published errors as error vectors, ready to be fitted."""

from functools import cache

import numpy as np

from scripts.nist_parts import FAMILIES, NistPart, parts, profile_of, table1_touches
from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging, error_vectors
from trueloop.units import UM_PER_MM

MODBAS2 = next(family for family in FAMILIES if family.name == "MODBAS2")


@cache
def table1() -> tuple[Profile, ErrorVectors, Array]:
    """[6517] Table 1: profile, error vectors after the semi-finish cut, and errors in µm after the finish cut."""
    profile = profile_of(MODBAS2, MODBAS2.largest_in)
    finish_um = np.array([(touch.error_mm or 0.0) * UM_PER_MM for touch in table1_touches("finish_error_um")])
    return profile, error_vectors(profile, table1_touches(), Gauging(z_reference="11")), finish_um


@cache
def nist_parts(family: str) -> tuple[NistPart, ...]:
    """The measured parts of a family of [6811]."""
    return tuple(part for part in parts() if part.family.name == family)


def semifinish(part: NistPart) -> ErrorVectors:
    """Error vectors of a part after the semi-finish cut."""
    return error_vectors(part.profile, part.semifinish, Gauging())


def finish_um(part: NistPart) -> Array:
    """Errors of a part after NIST's finish cut, in µm, in the order of the touches."""
    return np.array([(touch.error_mm or 0.0) * UM_PER_MM for touch in part.finish])
