"""The fit of lines: a straight line by least squares [6517 §2, 6811 §3.2]."""

from typing import Final

import numpy as np

from trueloop.turned.fit.chain import Chain, TangentPolicy
from trueloop.turned.fit.chain_fit import ChainFit, ChainTouches, Sources, own_fit
from trueloop.turned.fit.knots import Knots, fit_determined, joint_repeats
from trueloop.turned.fit.spline import EndConditions
from trueloop.wording import wording

SHORT_SPAN: Final = 0.1
"""Touches that span less than this share of a line say nothing of its slope: drawn out to the ends, their scatter would
be multiplied by ten and more. The line gets a constant."""


def fit_lines(
    name: str,
    chain: Chain,
    touches: ChainTouches,
    policy: TangentPolicy,
    conditions: EndConditions,
    sources: Sources,
) -> ChainFit:
    """Fits a straight line; a constant where the touches carry no more. Lines in line with each other are fitted as
    one.

    Under the policy PART the line may bend where one feature ends and the next begins, under PATH it may not.
    """
    s = touches.arc_length_mm
    short = len(s) > 1 and float(np.ptp(s)) < SHORT_SPAN * chain.length_mm and not conditions.count
    degree = 0 if short else 1
    repeats = joint_repeats(policy, degree)
    knots = Knots((), chain.joints_mm if repeats > 0 else (), repeats)
    fit, _ = fit_determined(s, touches.error_mm, knots, chain.length_mm, degree, conditions)
    note = wording("straight line through {n} touches by least squares", n=len(s))
    if short:
        note = wording("{n} touches span less than a tenth of the length: their mean, no slope", n=len(s))
    elif fit.spline.degree == 0:
        note = wording(
            "one touch: its error holds for the whole feature, a taper cannot be seen, nor whether the touch is bad"
        )
    elif len(s) == 2:
        note = wording("straight line through its two touches: a bad one would look like a taper")
    return own_fit(chain, touches, fit, sources, wording("{feature}: {note}", feature=name, note=note))
