"""How well sets of causes explain the errors of a series: marginal likelihoods from products of whitened columns.

Errors have the uncertainties of their devices and what parts of a sound process differ by (`sound`), of several sizes
and with waviness or without. A cause is a fresh copy of terms: columns with normal coefficients of unknown size, which
are tried on a grid. The scale of all variances is integrated out (Student's t with STATED degrees beforehand).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from trueloop.arrays import Array, Flags, Integers, by_content
from trueloop.diagnosis.causes.cause import SeenBy, SurfaceErrors
from trueloop.estimate.catalogue import Catalogue, Prior, Sizes, Term
from trueloop.estimate.places import Places
from trueloop.estimate.state import State
from trueloop.estimate.weights import log_student, tried

PROCESS_MM: Final = (
    (0.0005, 0.0003, 0.25), (0.0005, 0.0010, 0.2), (0.0015, 0.0003, 0.2), (0.0015, 0.0010, 0.2), (0.0040, 0.0030, 0.15),
)  # fmt: skip
"""Standard deviations from part to part of a sound process: of a tool, of a feature beside it; with probabilities."""
SCATTER_MM: Final = ((0.0002, 0.4), (0.0008, 0.4), (0.0018, 0.2))
"""Standard deviations from place to place of one sound part, with prior probabilities."""
CHATTER_MM: Final = (0.003, 0.008)
"""Further standard deviations from place to place of wavy shafts, equally probable."""

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
    """Returns the errors by one standard deviation of each at places, (n, m), without columns of zeros."""
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


STATED: Final = 30.0
"""How many observations the stated uncertainties are worth, beside what the errors themselves say of their noise."""
QUICK_MM: Final = (0.004, 0.030)
SIZES_MM: Final = (0.002, 0.006, 0.020, 0.080, 0.400)
"""Standard deviations of what a cause leaves: what is tried at first look, and what is tried."""
GROWING: Final = ("clamping", "group", "surface", "waviness")
"""Sizes of a sound process that are tried, and of waviness."""
SURFACES_MM: Final = (
    *((scatter, 0.0, share) for scatter, share in SCATTER_MM),
    *((SCATTER_MM[1][0], waviness, 1.0 / len(CHATTER_MM)) for waviness in CHATTER_MM),
)
"""Scatter from place to place, waviness beside it, and how probable each is beforehand, with waviness or without."""


@by_content
@dataclass(frozen=True)
class WhitenedProducts:
    """Products of whitened columns and values by the size of the sound process (p); `wavy` (p,): with waviness."""

    log_prior: Array
    columns: Array
    with_values: Array
    values: Array
    count: int
    wavy: Array

    def only(self, wavy: bool) -> "WhitenedProducts":
        """With waviness, or without."""
        return self.chosen(self.wavy == float(wavy))

    def chosen(self, rows: Flags) -> "WhitenedProducts":
        """Some sizes of the process."""
        return WhitenedProducts(
            log_prior=self.log_prior[rows],
            columns=self.columns[rows],
            with_values=self.with_values[rows],
            values=self.values[rows],
            count=self.count,
            wavy=self.wavy[rows],
        )


@dataclass(frozen=True)
class Size:
    """The largest effect of a block of columns, mm, and what it leaves at each point, mm."""

    mm: float
    standard_u_mm: float
    effect_mm: Array


@by_content
@dataclass(frozen=True)
class Products:
    """As `Weighed`, for values without corrections and for corrections: (p, k + 2, k + 2), the last two of values."""

    log_prior: Array
    joined: Array
    count: int
    wavy: Array

    def at(self, gain: float) -> WhitenedProducts:
        """Of the values as they had been without correction, if `gain` of what is recorded arrived: E = F + g C."""
        sum_of = np.array([1.0, gain])
        return WhitenedProducts(
            log_prior=self.log_prior,
            columns=self.joined[:, :-2, :-2],
            with_values=self.joined[:, :-2, -2:] @ sum_of,
            values=sum_of @ (self.joined[:, -2:, -2:] @ sum_of[:, None])[..., 0].T,
            count=self.count,
            wavy=self.wavy,
        )


def products_of(errors: SurfaceErrors, of_causes: Array) -> Products:
    """Of n errors and the columns (n, k) of all causes."""
    lasting = columns(LASTING, errors.places)
    joined = np.column_stack([lasting, of_causes, errors.value_mm, errors.corrected_mm])
    parts = [_Part.of(errors, rows, joined) for rows in errors.parts()]
    found, log_prior, wavy = [], [], []
    for (clamping, group, of_process), (surface, waviness, of_surface) in product(PROCESS_MM, SURFACES_MM):
        total, half = np.zeros((joined.shape[1], joined.shape[1])), 0.0
        for part in parts:
            lower = part.factor((clamping, group, surface, waviness))
            white = solve_triangular(lower, part.columns, lower=True, check_finite=False)
            total[np.ix_(part.used, part.used)] += white.T @ white
            half += float(np.log(np.diag(lower)).sum())
        left, of_lasting = _without(total, lasting.shape[1])
        found.append(left)
        log_prior.append(np.log(of_process * of_surface) - half - of_lasting)
        wavy.append(float(waviness > 0.0))
    return Products(np.array(log_prior), np.array(found), len(errors), np.array(wavy))


@dataclass(frozen=True, eq=False)
class _Part:
    """One part: which columns act on it and what they are there; covariances by what they grow with."""

    used: Integers
    columns: Array
    fixed_mm2: Array
    growing: tuple[Array, ...]

    @classmethod
    def of(cls, errors: SurfaceErrors, rows: Integers, joined: Array) -> "_Part":
        places = errors.places.chosen(rows)

        def covariance(size: str) -> Array:
            state = State.before(OF_PART, of_one_size(size)).at(places)
            design = state.design(places)
            scatter = np.diag(OF_PART.repeatability_mm2(places, state.sizes))
            return np.asarray((design * np.diag(state.covariance)) @ design.T + scatter)

        fixed = np.diag(errors.standard_u_mm[rows] ** 2)
        for name, size in OF_PART.medians.items():
            if name not in GROWING:
                fixed = fixed + size**2 * covariance(name)
        used = np.flatnonzero(np.any(joined[rows] != 0.0, axis=0))
        return cls(used, joined[np.ix_(rows, used)], fixed, tuple(covariance(name) for name in GROWING))

    def factor(self, sizes_mm: Sequence[float]) -> Array:
        """Lower factor of the covariance of its errors, with sizes in the order of `GROWING`."""
        whole = self.fixed_mm2.copy()
        for size, covariance in zip(sizes_mm, self.growing, strict=True):
            whole += size**2 * covariance
        return np.asarray(cholesky(whole, lower=True, check_finite=False))


def log_evidence(products: WhitenedProducts, blocks: Sequence[Integers]) -> float:
    """Logarithm of the marginal likelihood of the values if the columns of these blocks act."""
    log, _ = _tried(products, blocks)
    return float(np.logaddexp.reduce(log, axis=None) - np.log(log.shape[1]))


def log_beside(products: WhitenedProducts, first: Integers, others: Sequence[Integers]) -> list[float]:
    """Returns log likelihoods of one block with each of several others, at the process and the size best for the first.

    What is left out is small beside what tells the others apart: a quick first look at many pairs.
    """
    log, scales = _tried(products, [first])
    row, best = np.unravel_index(int(np.argmax(log)), log.shape)
    at = products.chosen(np.arange(len(products.wavy)) == row)
    blocks, sizes = ([first], [(float(scales[best][0]),)]) if len(first) else ([], [])
    looked = (_tried(at, [*blocks, one], [*sizes, QUICK_MM])[0] for one in others)
    return [float(np.logaddexp.reduce(log, axis=None)) for log in looked]


def size_of(products: WhitenedProducts, blocks: Sequence[Integers], hypothesis: int, of_block: Array) -> Size:
    """Of one of the blocks, where the others act too; `of_block` (n, k) are its own columns."""
    log, scales = _tried(products, blocks)
    process, best = np.unravel_index(int(np.argmax(log)), log.shape)
    chosen = np.concatenate(blocks)
    scale = scales[best]
    inner = np.eye(len(chosen)) + scale[:, None] * products.columns[process][np.ix_(chosen, chosen)] * scale
    covariance = scale[:, None] * np.linalg.inv(inner) * scale
    mean = covariance @ products.with_values[process][chosen]
    first = sum(len(block) for block in blocks[:hypothesis])
    own = slice(first, first + len(blocks[hypothesis]))
    effect = of_block @ mean[own]
    largest = int(np.argmax(np.abs(effect)))
    u = float(np.sqrt(of_block[largest] @ covariance[own, own] @ of_block[largest]))
    return Size(float(effect[largest]), u, effect)


def _tried(
    products: WhitenedProducts, blocks: Sequence[Integers], sizes_mm: Sequence[Sequence[float]] | None = None
) -> tuple[Array, Array]:
    """Logarithms by process (p, m) and sizes of all columns (m, k)."""
    chosen = np.concatenate([np.arange(0), *blocks]).astype(int)
    of = np.repeat(np.arange(len(blocks)), [len(block) for block in blocks])
    scales = tried(sizes_mm or [SIZES_MM] * len(blocks), of)
    gram, right = products.columns[:, None, chosen[:, None], chosen], products.with_values[:, None, chosen]
    log = log_student(gram, right, products.values[:, None], products.count, scales**2, STATED)
    return products.log_prior[:, None] + log, scales


def _without(products: Array, count: int) -> tuple[Array, float]:
    """Products with the first columns, of size 1, integrated out, and half the logarithm of what that divides by."""
    inner = np.eye(count) + products[:count, :count]
    left = products[count:, count:] - products[count:, :count] @ np.linalg.solve(inner, products[:count, count:])
    return left, 0.5 * float(np.linalg.slogdet(inner)[1])
