"""Waves around the turn, where the angle of the part is known: one of a chuck that runs out, three of its jaws.

The sources do not treat roundness; amplitudes of waves a turn are those of ISO 12181's harmonics.
"""

from typing import Final

import numpy as np

from trueloop.diagnosis.features.feature_error import ErrorKind, FeatureError
from trueloop.diagnosis.features.form import Form

KINDS: Final = {1: ErrorKind.ECCENTRICITY, 3: ErrorKind.LOBING}


def roundness_of(form: Form, name: str) -> tuple[FeatureError, ...]:
    """Amplitudes of the waves that the angles determine, as means over the feature; () where they determine none.

    The amplitude A of two fitted coefficients with uncertainties u₁, u₂ follows Rice's distribution, Rayleigh's where
    nothing is there: noise alone has a mean square of u₁² + u₂². That is taken out, a² = A² − u₁² − u₂², 0 where
    negative. u is that of the component along the wave and a quarter of what was taken out, without which ± 2 u would
    miss amplitudes of about 2 u too often. Value ± 2 u holds the true amplitude in 93 % of cases or more, of 0 to 10 u
    (simulated). `more` has the angle of the highest point from the zero of the spindle.
    """
    smooth = form.line if form.smooth is None else form.smooth
    first = len(smooth.coefficients) - 2 * len(form.waves)
    found = []
    for k, waves in enumerate(form.waves):
        pair = slice(first + 2 * k, first + 2 * k + 2)
        parts, covariance = smooth.coefficients[pair], smooth.covariance[pair, pair]
        amplitude = float(np.hypot(*parts))
        way = parts / max(amplitude, 1e-300)
        value = float(np.sqrt(max(amplitude**2 - float(np.trace(covariance)), 0.0)))
        u = float(np.sqrt(way @ covariance @ way)) + (amplitude - value) / 4.0
        more = {"highest_rad": float(np.arctan2(parts[1], parts[0])) / waves}
        found.append(
            FeatureError(name, KINDS[waves], value, u, form.points.readings, form.degrees_of_freedom, more=more)
        )
    return tuple(found)
