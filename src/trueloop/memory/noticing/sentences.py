"""Possible causes of a change, in words."""

from typing import Final

from trueloop.arrays import Array
from trueloop.memory.noticing.alarm import LeftOut
from trueloop.statistics import rms
from trueloop.wording import Signed, Um, wording

SLIPS: Final = (-1.0, 0.0, 0.5, 2.0)
"""Shares of a correction that a slip in the shop makes: wrong sign, not run, a radius entered
where a diameter belongs, and run twice or a diameter entered where a radius belongs."""
SLIPS_OF_MEMORY: Final = (0.0, 2.0)
NEAR: Final = 0.12
"""A gain this near to one of them is taken for it."""


def is_slip(gain: float, slips: tuple[float, ...] = SLIPS) -> bool:
    """Returns whether a slip in the shop makes such a share of a correction arrive."""
    return any(abs(gain - known) < NEAR for known in slips)


def of_level(shift: Array, before_finish: bool) -> str:
    """Describes a part with a displaced level: (dX, dZ), mm."""
    x, z = Um(shift[0], "+.1f"), Um(shift[1], "+.1f")
    if before_finish:
        return wording(
            "the part differs by {x} in X (radius) and {z} in Z from what earlier parts predict: the tool was set, an "
            "offset was entered or the work was clamped otherwise",
            x=x,
            z=z,
        )
    return wording(
        "the finished part differs by {x} in X (radius) and {z} in Z from what was predicted: an offset changed "
        "between the two cuts, or the finish cut was made otherwise",
        x=x,
        z=z,
    )


def of_shape(rest_mm: Array, before_finish: bool) -> str:
    """Describes a part whose error has another form: the remainder without its level, (n,), mm."""
    form = Um(rms(rest_mm))
    if before_finish:
        return wording(
            "the form of the error differs by {form} RMS from that of the edge: the edge was turned or changed, it "
            "chipped, or the stock is another",
            form=form,
        )
    return wording(
        "the form that the finish cut left differs by {form} RMS from what was predicted: the edge was turned or "
        "chipped between the cuts, or depth of cut or feed differ",
        form=form,
    )


def of_gain(gain: float) -> str:
    """Describes a correction of which another share arrived than all of it."""
    share = Signed(gain, 2)
    if abs(gain) < NEAR:
        return wording("{gain} of the correction arrived: the corrected program or offset was not run", gain=share)
    if abs(gain - 2) < NEAR:
        return wording(
            "{gain} of the correction arrived: it was applied twice, or a diameter was entered as a radius", gain=share
        )
    if abs(gain - 0.5) < NEAR:
        return wording("{gain} of the correction arrived: a radius was entered as a diameter", gain=share)
    if abs(gain + 1) < NEAR:
        return wording("{gain} of the correction arrived: it was applied with the wrong sign", gain=share)
    return wording("{gain} of the correction arrived: it was changed, or something else makes the error", gain=share)


def of_memory(gain: float) -> str:
    """Describes memory's addition to a correction of which another share arrived than all of it."""
    share = Signed(gain, 2)
    if abs(gain) < NEAR:
        return wording("{gain} of what memory added to the correction arrived: it was not applied", gain=share)
    if abs(gain - 2) < NEAR:
        return wording("{gain} of what memory added to the correction arrived: it was applied twice", gain=share)
    return wording("{gain} of what memory added to the correction arrived", gain=share)


def of_left_out(touch: LeftOut) -> str:
    """Describes a touch that the others contradict."""
    return wording(
        "touch {point} was left out: it differs by {z} standard deviations from what all others say of it",
        point=touch.point,
        z=Signed(touch.deviations, 1),
    )
