"""A characteristic judged from the part errors at its places and their covariance."""

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic
from trueloop.tolerances.conformance import judge
from trueloop.tolerances.judged import Judgement
from trueloop.turned.characteristics.covariance import Covariance
from trueloop.turned.characteristics.measurand import Measurand


def judged(asked: Characteristic, sizes: Measurand, error_mm: Array, covariance: Covariance) -> Judgement:
    """Every size against the limits: the one that is least likely to be inside speaks for all."""
    values = sizes.nominal + sizes.gains @ error_mm
    standard_u, freedom = covariance.of(sizes.gains)
    each = [
        judge(value, u, known, asked.lower_limit, asked.upper_limit)
        for value, u, known in zip(values.tolist(), standard_u.tolist(), freedom, strict=True)
    ]
    return min(each, key=lambda one: (one.probability_in, one.margin or 0.0))
