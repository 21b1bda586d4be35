"""What the nose model makes of the ten worn-nose parts of [6811], and the page docs/nose-model.md that says so.

`python -m scripts.nist_nose` prints the page, `--write` writes it.
"""

import argparse
import itertools
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Final

import numpy as np

from scripts.nist_parts import parts
from trueloop.statistics import rms
from trueloop.turned.fit.nose_fit import NoseModel, NoseTouches, fit_nose_model, nose_touches
from trueloop.turned.touches.touches import Gauging, error_vectors
from trueloop.units import UM_PER_MM

PAGE: Final = Path(__file__).parents[1] / "docs" / "nose-model.md"

PLACES: Final[dict[str, tuple[int, ...]]] = {
    "two: the 3rd and the 18th": (2, 17),
    "three: these and the 10th": (2, 9, 17),
    "all twenty": tuple(range(20)),
}
"""Touches by their place among the twenty of a dome or knob."""

HEAD: Final = """# One nose, many parts

A worn tool nose errs where it is worn: the part error depends on the contact angle φ, the direction of the surface's
normal from the spindle axis (0° an end face, 90° a cylinder). `turned/fit/nose_fit.py` takes it apart:

```text
e = w(φ) + dX·sin φ + dZ·cos φ + what is left on a straight feature
```

w belongs to the nose and is shared by all parts it cuts; dX and dZ are this part's tool offsets. With w known from
other parts, two touches set the offsets and the whole arc is known.

The numbers below are measured, not simulated: the errors after the semi-finish cut of NISTIR 6811, Table 8 (four
MODBAS2 parts with a dome) and Table 10 (six PIECS11 parts with a knob), all cut by one worn insert. Every prediction is
for a part that the nose model has not seen.
"""

FOOT: Final = """
`python -m scripts.nist_nose --write` makes this page; a test compares it with what the code gives.
"""


@cache
def family(name: str) -> tuple[NoseTouches, ...]:
    """The touches of a family's parts after the semi-finish cut, by contact angle."""
    return tuple(
        nose_touches(part.number, part.profile, error_vectors(part.profile, part.semifinish, Gauging()))
        for part in parts()
        if part.family.name == name
    )


def arc_of(part: NoseTouches) -> NoseTouches:
    """The touches on the dome or knob."""
    return part.subset(part.on_arc)


@cache
def left_out() -> tuple[tuple[NoseTouches, NoseModel], ...]:
    """Each of the ten parts, with the nose model of the other nine."""
    ten = [*family("MODBAS2"), *family("PIECS11")]
    return tuple((part, fit_nose_model([*ten[:k], *ten[k + 1 :]])) for k, part in enumerate(ten))


def left_out_rms_um(places: Sequence[int]) -> float:
    """RMS over all twenty points of all ten parts, offsets from the touches at some places."""
    errors = []
    for part, nose in left_out():
        arc = arc_of(part)
        expected = nose.predict(arc.subset(list(places))).value_mm(arc.contact_angle_rad)
        errors.append(arc.error_mm - expected)
    return rms(np.concatenate(errors)) * UM_PER_MM


def mean_knob(nose: NoseModel) -> NoseTouches:
    """The mean of the six PIECS11 knobs at the angles within a nose model's fitted range."""
    arcs = [arc_of(part) for part in family("PIECS11")]
    angle = np.mean([arc.contact_angle_rad for arc in arcs], axis=0)
    error = np.mean([arc.error_mm for arc in arcs], axis=0)
    shared = (angle >= nose.lowest_rad) & (angle <= nose.highest_rad)
    return NoseTouches("mean knob", ("knob",) * 20, np.ones(20, dtype=np.bool_), angle, error).subset(shared)


def transfer_um() -> tuple[float, float]:
    """MODBAS2's nose on the mean PIECS11 knob: RMS with MODBAS2's own mean offsets, and with the knob's."""
    nose = fit_nose_model(family("MODBAS2"))
    knob = mean_knob(nose)
    angle = knob.contact_angle_rad
    terms = np.column_stack([np.sin(angle), np.cos(angle)])
    as_before = nose.w_mm(angle) + terms @ np.mean(list(nose.offsets_mm.values()), axis=0)
    after = nose.predict(knob).value_mm(angle)
    return rms(knob.error_mm - as_before) * UM_PER_MM, rms(knob.error_mm - after) * UM_PER_MM


def left_on_cones_um() -> dict[str, float]:
    """What is left on the cone of every part, by part."""
    noses = [fit_nose_model(family(name)) for name in ("MODBAS2", "PIECS11")]
    left = [item for nose in noses for item in nose.left_mm.items()]
    return {part: off * UM_PER_MM for (part, feature), off in left if feature == "cone"}


def median_um(touches: int, step: int) -> float:
    """Median over every `step`-th choice of so many places, at least three apart."""
    choices = itertools.islice(itertools.combinations(range(20), touches), 0, None, step)
    apart = [places for places in choices if min(np.diff(places)) > 2]
    return float(np.median([left_out_rms_um(places) for places in apart]))


def page() -> str:
    """The whole page."""
    before, after = transfer_um()
    rows = [f"| {name} | {left_out_rms_um(places):.1f} |" for name, places in PLACES.items()]
    cones = left_on_cones_um()
    usual = sorted(off for part, off in cones.items() if part != "2811")
    text = f"""
## How many touches

Ten parts, each left out in turn. RMS error of the prediction over the twenty points of its dome or knob:

| Touches on the arc | Left out, µm |
|---|--:|
{chr(10).join(rows)}

Where the touches lie matters little: the median is {median_um(2, 1):.1f} µm over all pairs at least three places apart,
{median_um(3, 5):.1f} µm over triples.

## From one part to another

Fitted on the four MODBAS2 parts alone, w is asked for the mean PIECS11 knob within the shared angles. With MODBAS2's
offsets it is off by {before:.0f} µm RMS, because the tool stood elsewhere; with two offsets of its own by
{after:.1f} µm.

## What it does not know

Straight features stand off by a constant of their own: the cones by {usual[0]:.0f} to {usual[-1]:.0f} µm, alike over
both designs, and by {cones["2811"]:.0f} µm on part 2811, where a false taper shows (the report says that some
tapers were falsified on purpose, not which). The model leaves straight features to their own touches.
"""
    return f"{HEAD}{text}{FOOT}"


def main() -> None:
    """Print or write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    if parser.parse_args().write:
        PAGE.write_text(page(), encoding="utf-8")
    else:
        print(page())


if __name__ == "__main__":
    main()
