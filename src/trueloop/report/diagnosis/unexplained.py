"""What no cause explains: a page that says that nothing acts must not hide an error that is there."""

from collections.abc import Iterator, Sequence
from typing import Final

from trueloop.report.diagnosis.shapes import CausesShape, FeatureMeansShape, MeanShape, UnexplainedShape

PROBABLE: Final = 0.5
"""Causes that together have less probability explain nothing."""
MEAN: Final = 4.0
"""Standard uncertainties from which a mean is said to be there: one of some hundred errors of sound parts at most."""
SCATTER: Final = 5.0
"""Standard uncertainties of one part from which parts differ: cuts repeat less well than a probe does."""


def unexplained(means: Sequence[FeatureMeansShape], causes: CausesShape) -> list[UnexplainedShape]:
    """Errors beyond their uncertainty on features on which probably nothing acts, furthest first."""
    free = [one for one in means if acting(one.feature, causes) < PROBABLE]
    found = [each for one in free for each in _of(one)]
    return sorted(found, key=lambda each: -abs(each.size_um) / max(each.standard_u_um, 1e-6))


def acting(feature: str, causes: CausesShape) -> float:
    """Probability that one cause or another acts on a feature; a cause without features acts on all."""
    on = {one.key for one in causes.candidates if feature in one.features or not one.features}
    return sum(one.probability for one in causes.hypotheses if on & set(one.causes))


def _of(one: FeatureMeansShape) -> Iterator[UnexplainedShape]:
    """Of one error at most one for each device: its mean, else its scatter."""
    for device, mean in (("machine", one.machine), ("CMM", one.cmm)):
        if mean is not None and (shown := _beyond(one, device, mean)) is not None:
            yield shown


def _beyond(one: FeatureMeansShape, device: str, mean: MeanShape) -> UnexplainedShape | None:
    known = {"feature": one.feature, "other": one.other, "kind": one.kind, "device": device}
    if mean.standard_u_um is not None and abs(mean.mean_um) > MEAN * mean.standard_u_um > 0.0:
        return UnexplainedShape(**known, shows="mean", size_um=mean.mean_um, standard_u_um=mean.standard_u_um)
    scatter, u = mean.scatter_um, mean.one_part_u_um
    if scatter is not None and u is not None and scatter > SCATTER * u > 0.0:
        return UnexplainedShape(**known, shows="scatter", size_um=scatter, standard_u_um=u)
    return None
