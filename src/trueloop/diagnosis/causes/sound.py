"""What parts of a sound process differ by, as terms of the estimate, and what devices read wrongly in any case."""

from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.causes.seen_part import SeenBy
from trueloop.estimate.places import Places
from trueloop.estimate.term import Catalogue, Prior, Sizes, Term

PROCESS_MM: Final = (
    (0.0005, 0.0003, 0.25), (0.0005, 0.0010, 0.2), (0.0015, 0.0003, 0.2), (0.0015, 0.0010, 0.2), (0.0040, 0.0030, 0.15),
)  # fmt: skip
"""What cuts of a sound process differ by from part to part: a tool, a feature beside that, and how probable each is."""
SCATTER_MM: Final = ((0.0002, 0.4), (0.0008, 0.4), (0.0018, 0.2))
"""What places of one sound part differ by, with how probable each is beforehand."""
CHATTER_MM: Final = (0.003, 0.008)
"""What places of shafts differ by beside that where there is waviness, each as probable."""

_DATUM: Final = "z counts from a face that each device finds anew, on a part that is not unclamped for it"
_PROCESS: Final = "a part clamped again, a turret indexed, minutes of heat: some micrometres at most"
_SURFACE: Final = "roughness and marks of the feed under a touch: some tenths of a micrometre to some micrometres"
_FRAME: Final = "the frame of a part on a measuring machine is turned by some microradians"


def _cut(places: Places) -> Array:
    return places.number("cut")[:, None]


def _normal(places: Places) -> Array:
    return np.column_stack([places.number("normal_x"), places.number("normal_z")])


def _datum(places: Places) -> Array:
    """Where z counts from; of faces alone too, as corrections of lengths do not say what was taken off all of them."""
    along = places.number("normal_z")
    return np.column_stack([along, along * places.number("face")])


def _shaft(places: Places) -> Array:
    return np.asarray(1.0 - places.number("face")[:, None])


def _tilted(places: Places) -> Array:
    """A frame of a measuring machine that is out across the axis, and turned about y."""
    angle = places.number("spindle_rad")
    side = places.number("normal_x") * np.where(np.isnan(angle), 1.0, np.cos(angle))
    outside = np.array([float(one == SeenBy.CMM.value) for (one,) in places.labels(("device",))])
    return np.asarray(np.column_stack([side, side * places.number("z_mm")]) * outside[:, None])


def _along(places: Places, degree: int) -> Array:
    return np.asarray(np.polynomial.legendre.legvander(places.number("share"), degree))


OF_PART: Final = Catalogue(
    (
        Term("datum", ("part", "device"), _datum, lambda s: np.full(2, s["datum"])),
        Term("clamping", ("part", "tool"), lambda p: _normal(p) * _cut(p), lambda s: np.full(2, s["clamping"])),
        Term("frame", ("part", "device"), _tilted, lambda s: np.full(2, [s["across"], s["tilt"]])),
        Term(
            "group of the part",
            ("part", "feature"),
            lambda p: np.column_stack([np.ones(len(p)), p.number("share")]) * _cut(p),
            lambda s: s["group"] * np.array([1.0, 0.6]),
        ),
        Term("surface", ("part", "at"), _cut, lambda s: np.array([s["surface"]])),
        Term("waviness", ("part", "at"), lambda p: _shaft(p) * _cut(p), lambda s: np.array([s["waviness"]])),
    ),
    lambda places, sizes: np.zeros(len(places)),
    {
        "clamping": Prior(0.0010, 0.9, _PROCESS),
        "group": Prior(0.0006, 0.9, _PROCESS),
        "datum": Prior(0.020, 0.5, _DATUM),
        "across": Prior(0.0005, 0.5, _FRAME),
        "tilt": Prior(4.0e-6, 0.5, _FRAME),
        "surface": Prior(0.0008, 0.9, _SURFACE),
        "waviness": Prior(0.004, 1.0, _SURFACE),
    },
)
"""Terms of one part alone."""

LASTING: Final = (
    Term("device", ("device",), lambda p: _normal(p)[:, :1], lambda s: np.array([0.0005])),
    Term("device's form", ("device", "feature"), lambda p: _along(p, 3), lambda s: np.array([4, 3, 2, 2]) * 1e-4),
    Term("form", ("feature",), lambda p: _along(p, 3) * _cut(p), lambda s: np.array([4, 3, 4, 3]) * 1e-4),
)
"""Terms that all parts share; sizes in mm, with sources as above."""


def of_one_size(name: str) -> Sizes:
    """Sizes of the terms of a part of which one is 1 mm and all others 0: covariances are sums of such with squares."""
    return {other: float(other == name) for other in OF_PART.priors}


def columns(terms: tuple[Term, ...], places: Places, unit: bool = False) -> Array:
    """What one standard deviation of each coefficient leaves at places, (n, m); `unit`: the coefficients alone.

    A coefficient that does nothing at any of the places is left out.
    """
    found = [np.zeros((len(places), 0))]
    for term in terms:
        values = term.basis(places)
        if not unit:
            values = values * term.spread({})
        labels = places.labels(term.scope)
        number = {label: k for k, label in enumerate(dict.fromkeys(labels))}
        whole = np.zeros((len(places), len(number), values.shape[1]))
        whole[np.arange(len(places)), [number[label] for label in labels]] = values
        found.append(whole.reshape(len(places), -1))
    joined = np.hstack(found)
    return np.asarray(joined[:, np.any(joined != 0.0, axis=0)])
