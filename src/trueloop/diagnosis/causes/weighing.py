"""How well sets of causes explain the signed errors of a series: marginal likelihoods from products of columns.

The errors have their own uncertainties and what cuts of a sound process differ by, from part to part: both devices see
that alike, half of it is a tool's and half a feature's own. Its size is not known, so several are tried. Whitened by
both, the errors have noise of the variance 1 (not known either: Student's t, as in `diagnosis.evidence`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.diagnosis.causes.rows import Row
from trueloop.diagnosis.features.feature_error import ErrorKind

PROCESS_MM: Final = ((0.0003, 0.25), (0.0007, 0.25), (0.0012, 0.25), (0.0025, 0.15), (0.0050, 0.1))
"""What cuts of a sound process differ by, with how probable each is beforehand."""
DEVICE_MM: Final = 0.0005
"""What a device reads wrongly on all parts alike: its zero, and parts that cool between two inspections."""
STATED: Final = 12.0
"""How many observations the stated uncertainties are worth, beside what the errors themselves say of their noise."""
SIZES_MM: Final = (0.002, 0.006, 0.020, 0.080, 0.400)
"""Standard deviations of what a cause leaves: what is tried."""


@by_content
@dataclass(frozen=True)
class Weighed:
    """Products of whitened columns and values, one of each for every process scatter that is tried."""

    log_prior: Array
    columns: Array
    with_values: Array
    values: Array
    count: int


@dataclass(frozen=True)
class Size:
    """The largest effect of a block of columns, mm, and which rows it shows on by how much, mm."""

    mm: float
    standard_u_mm: float
    effect_mm: Array


def weighed(rows: Sequence[Row], tool_of: Mapping[str, str], columns: Array, values_mm: Array) -> Weighed:
    """Of n rows, with the tools of features; columns (n, k), values (n,)."""
    joined = np.column_stack([_devices(rows), columns, values_mm])
    found, log_det = [], []
    for size, _ in PROCESS_MM:
        products, half = _without_devices(
            _products(rows, tool_of, joined, size), joined.shape[1] - columns.shape[1] - 1
        )
        found.append(products)
        log_det.append(half + _half_log_det(rows, tool_of, size))
    log_prior = np.log([share for _, share in PROCESS_MM]) - log_det
    all_of = np.array(found)
    return Weighed(log_prior, all_of[:, :-1, :-1], all_of[:, :-1, -1], all_of[:, -1, -1], len(rows))


def log_evidence(given: Weighed, blocks: Sequence[slice]) -> float:
    """Logarithm of the marginal likelihood of the values if the columns of these blocks act."""
    log, _ = _tried(given, blocks)
    return float(np.logaddexp.reduce(log, axis=None) - np.log(log.shape[1]))


def size_of(given: Weighed, blocks: Sequence[slice], asked: int, columns: Array) -> Size:
    """Of one of the blocks, where the others act too; `columns` (n, k) are its own."""
    log, scales = _tried(given, blocks)
    process, best = np.unravel_index(int(np.argmax(log)), log.shape)
    chosen = np.concatenate([np.arange(one.start, one.stop) for one in blocks])
    scale = scales[best]
    inner = np.eye(len(chosen)) + scale[:, None] * given.columns[process][np.ix_(chosen, chosen)] * scale
    covariance = scale[:, None] * np.linalg.inv(inner) * scale
    mean = covariance @ given.with_values[process][chosen]
    first = sum(one.stop - one.start for one in blocks[:asked])
    own = slice(first, first + blocks[asked].stop - blocks[asked].start)
    effect = columns @ mean[own]
    largest = int(np.argmax(np.abs(effect)))
    u = float(np.sqrt(columns[largest] @ covariance[own, own] @ columns[largest]))
    return Size(float(effect[largest]), u, effect)


def _tried(given: Weighed, blocks: Sequence[slice]) -> tuple[Array, Array]:
    """Logarithms by process scatter and sizes (p, m), and the sizes of all columns (m, k)."""
    chosen = np.concatenate([np.arange(0), *[np.arange(one.start, one.stop) for one in blocks]]).astype(int)
    widths = [one.stop - one.start for one in blocks]
    scales = np.array([np.repeat(sizes, widths) for sizes in product(SIZES_MM, repeat=len(blocks))])
    products = given.columns[:, chosen[:, None], chosen]
    inner = np.eye(len(chosen)) + scales[:, :, None] * products[:, None] * scales[:, None, :]
    lower = np.linalg.cholesky(inner)
    with_values = scales * given.with_values[:, None, chosen]
    inside = np.linalg.solve(lower, with_values[..., None])[..., 0]
    squares = given.values[:, None] - (inside**2).sum(axis=-1)
    log_det = np.log(np.diagonal(lower, axis1=-2, axis2=-1)).sum(axis=-1)
    return given.log_prior[:, None] + _log_student(squares, given.count) - log_det, scales


def _devices(rows: Sequence[Row]) -> Array:
    """What each device reads wrongly of each kind of error on all parts, as columns."""
    cells = list(dict.fromkeys((row.kind, row.seen_by) for row in rows))
    return DEVICE_MM * np.array([[float((row.kind, row.seen_by) == cell) for cell in cells] for row in rows])


def _without_devices(products: Array, count: int) -> tuple[Array, float]:
    """Products with the first columns, of size 1, integrated out, and half the logarithm of what that divides by."""
    inner = np.eye(count) + products[:count, :count]
    left = products[count:, count:] - products[count:, :count] @ np.linalg.solve(inner, products[:count, count:])
    return left, 0.5 * float(np.linalg.slogdet(inner)[1])


def _products(rows: Sequence[Row], tool_of: Mapping[str, str], joined: Array, process_mm: float) -> Array:
    total = np.zeros((joined.shape[1], joined.shape[1]))
    for of_part in _parts(rows):
        lower = np.linalg.cholesky(_covariance([rows[k] for k in of_part], tool_of, process_mm))
        white = np.linalg.solve(lower, joined[of_part])
        total += white.T @ white
    return total


def _half_log_det(rows: Sequence[Row], tool_of: Mapping[str, str], process_mm: float) -> float:
    found = 0.0
    for of_part in _parts(rows):
        covariance = _covariance([rows[k] for k in of_part], tool_of, process_mm)
        found += 0.5 * float(np.linalg.slogdet(covariance)[1])
    return found


def _parts(rows: Sequence[Row]) -> list[list[int]]:
    return [[k for k, row in enumerate(rows) if row.part == part] for part in sorted({row.part for row in rows})]


def _covariance(rows: Sequence[Row], tool_of: Mapping[str, str], process_mm: float) -> Array:
    """Of the errors of one part: own variances, and what the cut of a tool and of a feature shares between devices."""
    cuts = [_cuts(row, tool_of) for row in rows]
    names = {name: k for k, name in enumerate(dict.fromkeys(name for one in cuts for name in one))}
    shares = np.zeros((len(rows), len(names)))
    for k, one in enumerate(cuts):
        for name, share in one.items():
            shares[k, names[name]] += share
    found: Array = np.diag([row.u_mm**2 for row in rows]) + 0.5 * process_mm**2 * shares @ shares.T
    return found


def _cuts(row: Row, tool_of: Mapping[str, str]) -> dict[tuple[str, str, str], float]:
    """Which cuts of tools and features an error is the sum of: a length of those of two faces."""
    kind = str(row.kind)
    if row.kind is not ErrorKind.LENGTH:
        return {("feature", kind, row.feature): 1.0, ("tool", kind, tool_of.get(row.feature, "")): 1.0}
    far, near = tool_of.get(row.feature, ""), tool_of.get(row.other, "")
    tools = {("tool", kind, far): 1.0, ("tool", kind, near): -1.0} if far != near else {}
    return {("feature", kind, row.feature): 1.0, ("feature", kind, row.other): -1.0} | tools


def _log_student(squares: Array, count: int) -> Array:
    """Of whitened values as sums of squares, but for the determinant; their variance has STATED observations of 1."""
    found: Array = -((STATED + count) / 2) * np.log1p(squares / STATED)
    return found
