"""The error curves of a correction as single pictures, each with what it shows in words."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from trueloop.loops.turned.correction import Correction
from trueloop.report import style
from trueloop.report.still import svg
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.figures.curves import SAMPLES, error_curve
from trueloop.units import UM_PER_MM


@dataclass(frozen=True)
class CurvePicture:
    """The curve of the profile's `number`-th feature, from 0; `said`: what the picture shows, for who cannot see it."""

    number: int
    feature: str
    said: str


def curve_pictures(correction: Correction, say: Texts) -> Iterator[CurvePicture]:
    """Yields the features with a curve: one touch makes a constant, of which no picture shows more than its number."""
    for number, feature in enumerate(correction.profile.features):
        if len(correction.touches.of_feature(number)) > 1:
            yield CurvePicture(number, feature.name, _said(correction, number, say))


def curve_svg(correction: Correction, number: int, width: int, say: Texts) -> str:
    """Draws the picture of one of them."""
    return svg(error_curve(correction, number, width, say), style.label(_said(correction, number, say)))


def _said(correction: Correction, number: int, say: Texts) -> str:
    curve, rows = correction.model.curves[number], correction.touches.of_feature(number)
    along = np.linspace(0.0, curve.length_mm, SAMPLES)
    value, band = curve.value_mm(along) * UM_PER_MM, curve.half_band_mm(along) * UM_PER_MM
    left = np.abs(correction.prediction.after_mm[rows]) * UM_PER_MM
    return say(
        "Error curve of {feature}: {n} touches, fitted from {low} to {high} {um} (+ is material left on), 95 % band at "
        "most ± {band} {um}; predicted after the cut at most {left} {um}.",
        feature=correction.profile.features[number].name,
        n=len(rows),
        low=say.error(float(np.min(value))),
        high=say.error(float(np.max(value))),
        band=say.size(float(np.max(band))),
        left=say.size(float(np.nanmax(left))),
    )
