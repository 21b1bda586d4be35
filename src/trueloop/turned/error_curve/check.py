"""Error vectors that no curve can be fitted to, and options that fit no profile."""

import math
from dataclasses import astuple

import numpy as np

from trueloop.errors import Code
from trueloop.geometry.profile import Profile
from trueloop.turned.fit.options import FitOptions
from trueloop.turned.touches.error_vectors import ErrorVectors


def check_vectors(profile: Profile, vectors: ErrorVectors) -> None:
    """Refuses error vectors that no curve can be fitted to."""
    if len(vectors.point) == 0:
        raise Code.FIT_POINTS.refusal(
            f"0 touches on the {len(profile.features)} features of the part: there is nothing to fit",
            hint="touch at least one point",
            values={"touches": 0},
        )
    numbers = np.column_stack([vectors.arc_length_mm, vectors.error_mm, vectors.standard_u_mm])
    bad = ~np.all(np.isfinite(numbers), axis=1) | (vectors.standard_u_mm < 0.0)
    if np.any(bad):
        k = int(np.argmax(bad))
        raise Code.FIT_VALUE.refusal(
            f"touch {vectors.point[k]!r}: arc length {vectors.arc_length_mm[k]} mm, error {vectors.error_mm[k]} mm, "
            f"standard uncertainty {vectors.standard_u_mm[k]} mm; all must be numbers, the last not negative",
            hint="mend or leave out this touch",
        )
    _check_order(vectors)


def _check_order(vectors: ErrorVectors) -> None:
    """Touches of one feature ascend, and no two stand in one place."""
    for k in range(1, len(vectors.point)):
        step = vectors.arc_length_mm[k] - vectors.arc_length_mm[k - 1]
        if vectors.feature_index[k] == vectors.feature_index[k - 1] and step <= 0.0:
            raise Code.FIT_ORDER.refusal(
                f"touch {vectors.point[k]!r} at {vectors.arc_length_mm[k]:.4f} mm along its feature follows "
                f"{vectors.point[k - 1]!r} at {vectors.arc_length_mm[k - 1]:.4f} mm",
                hint="order touches along the profile and average those taken at one place",
                values={
                    "points": list(vectors.point[k - 1 : k + 1]),
                    "arc_length_mm": vectors.arc_length_mm[k - 1 : k + 1].tolist(),
                },
            )


def check_options(profile: Profile, options: FitOptions) -> None:
    """Refuses options for features that the part does not have, and numbers that are none."""
    for code, named in ((Code.FIT_KNOTS, options.knot_every_on), (Code.FIT_CONDITIONS, options.prescribed)):
        for name in named:
            if name not in profile.names:
                raise code.refusal(
                    f"the fit has an option for feature {name!r}, which the part does not have",
                    hint=f"the part's features are: {', '.join(profile.names)}",
                )
    for name, conditions in options.prescribed.items():
        given = [number for number in astuple(conditions) if number is not None]
        if not all(math.isfinite(number) for number in given):
            raise Code.FIT_CONDITIONS.refusal(
                f"{name!r}: the prescribed values and slopes are {given} mm or mm/mm, not all of them finite",
                hint="give numbers, or leave an end free",
            )
    between = options.between_cuts
    for words, value_mm in (
        ("process", options.repeatability_mm),
        ("whole cut", between.common_mm),
        ("cut along its contour", between.scatter_mm),
    ):
        if value_mm is not None and not 0.0 <= value_mm < math.inf:
            raise Code.FIT_VALUE.refusal(
                f"the repeatability of the {words} is given as {value_mm} mm",
                hint="a standard deviation is a number and not negative; leave it out to take the touches' scatter",
            )
    alike = options.alike_over_mm
    if alike is not None and not 0.0 <= alike < math.inf:
        raise Code.FIT_VALUE.refusal(
            f"the process is said to be alike over {alike} mm along a cut",
            hint="a length is a number and not negative; leave it out to take what the touches say",
        )
