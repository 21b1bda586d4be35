"""Names of errors and devices, probabilities and sizes, as pages and lines write them."""

from collections.abc import Sequence

from trueloop.report.diagnosis.shapes import FeatureErrorShape, FeatureMeansShape, MeanShape, UnexplainedShape
from trueloop.report.markup import esc
from trueloop.report.texts.texts import ENGLISH, Texts

SEEN: float = 0.0005
"""A probability nearer to 0 or 1 is said to be below or above."""


def kind_name(kind: str, say: Texts = ENGLISH) -> str:
    """Returns a kind of error in the reader's language."""
    known = {
        "radius": say("radius"),
        "length": say("length"),
        "taper of a shaft": say("taper of a shaft"),
        "taper of a face": say("taper of a face"),
        "edge": say("edge"),
        "straightness": say("straightness"),
        "waviness": say("waviness"),
        "eccentricity": say("eccentricity"),
        "lobing": say("three lobes"),
    }
    return known.get(kind, kind)


def device_name(device: str, say: Texts = ENGLISH) -> str:
    """Returns the name of the device that saw an error."""
    return {"machine": say("machine’s probe"), "CMM": say("CMM or gauge")}.get(device, device)


def error_name(one: FeatureErrorShape | FeatureMeansShape | UnexplainedShape, say: Texts = ENGLISH) -> str:
    """Names the feature of an error, or both of a length, as plain text."""
    return f"{one.feature} − {one.other}" if one.other else one.feature


def share(probability: float, say: Texts = ENGLISH) -> str:
    """Formats a probability in percent; what is all but 0 or 1 as below or above."""
    if probability < SEEN:
        return f"< {say.number(100 * SEEN, 2)} %"
    if probability > 1 - SEEN:
        return f"> {say.number(100 * (1 - SEEN), 2)} %"
    return f"{say.number(100 * probability)} %"


def with_u(value_um: float | None, u_um: float | None, say: Texts = ENGLISH, *, signed: bool = True) -> str:
    """Formats a value ± its standard uncertainty; a dash where it is not known."""
    if value_um is None:
        return "–"
    text = say.error(value_um) if signed else say.size(value_um)
    return text if u_um is None else f"{text} ± {say.size(u_um)}"


def mean_with_u(mean: MeanShape | None, say: Texts = ENGLISH) -> str:
    """Formats a mean ± its standard uncertainty."""
    return "–" if mean is None else with_u(mean.mean_um, mean.standard_u_um, say)


def escaped(words: Sequence[str], say: Texts) -> list[str]:
    """Sentences of the diagnosis in the reader's language, harmless."""
    return [esc(say.note(one)) for one in words]
