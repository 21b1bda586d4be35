"""Every way in which points of features, and repeats at one point, are refused or flagged."""

from collections.abc import Callable

import numpy as np

from trueloop.diagnosis.features.errors_of import undetermined
from trueloop.diagnosis.features.feature_error import FeaturePlace, SeenPoints
from trueloop.diagnosis.features.fixturing import fixturing, unstable
from trueloop.errors import Code


def _one_place() -> object:
    points = SeenPoints(
        ("shaft",),
        np.array([[20.0, 80.0]]),
        np.array([[1.0, 0.0]]),
        np.array([0.004]),
        np.array([0.001]),
        np.array([np.nan]),
        np.array([1]),
    )
    return undetermined(points, {"shaft": FeaturePlace("shaft", "shaft", (20.0, 20.0), (0.0, 100.0))})


def _stepped() -> object:
    values = np.array([0.0001, -0.0002, 0.0003, 0.0151, 0.0148, 0.0150])
    return unstable("the part probe", fixturing(values, 0.0005, limit_mm=0.003))


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.DIA_FEW: lambda: fixturing(np.array([0.001, 0.002, 0.001]), 0.001),
    Code.DIA_POINTS: _one_place,
    Code.DIA_UNSTABLE: _stepped,
}
