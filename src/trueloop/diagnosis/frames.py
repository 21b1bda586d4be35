"""Part frames of machine and CMM reconciled over many parts [6876 §3.1]: a discrepancy of all, and of each part.

Along the normal n at the nominal point p of part k, with shifts s and turns t in the part's frame,

    CMM − machine = n · (s + t × p) + n · (s_k + t_k × p) + what the model left at the place + noise.

One part alone cannot divide these (`components.py`): many can, because the discrepancy of each part is its own, and
what the model left is the same at the place in every part. What looks like a rigid motion of *every* part stays
ambiguous: a constant error of X and a CMM that finds every part off by as much are the same numbers.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code, Finding, Severity
from trueloop.estimate.blocks import Block, mixed
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, Wording, wording

WIDEST_MM = 0.1
"""Prior of the discrepancy of all parts, standard deviation at the part's largest coordinate."""
LEAST_MM, MOST_MM = 1e-5, 0.064
"""Limits of the discrepancy of one part, and of the error left at a place."""
FAINTEST = 1e-6
FAR = 5.0
"""A part moved by more than so many times what the others are is not like them."""
LEAST_PARTS = 2


@dataclass(frozen=True)
class Motion:
    """A small rigid motion p → p + shift + turn × p between part frames; `standard_u` (6,), NaN: not seen, 0."""

    shift_mm: Array
    turn_rad: Array
    standard_u: Array


@dataclass(frozen=True)
class Frames:
    """The discrepancy common to all parts, that of each part, and the remainder at the places.

    `left_mm` (n,) is what the model left at each point apart from rigid motions of every part, `u_left_mm` (n,) its
    standard uncertainty; 0 where no place is seen in several parts. `moved` are parts that are not like the others,
    of which nothing but their own motion was used.
    """

    common: Motion
    own: Mapping[int, Motion]
    left_mm: Array
    u_left_mm: Array
    noise_mm: float
    moved: tuple[int, ...]
    findings: tuple[Finding, ...]

    @property
    def words(self) -> Wording:
        """Describes what is known and what cannot be."""
        return wording(
            "Over {parts} parts the frames differ by a shift of {x}, {y}, {z}; besides, {left} RMS stays at the "
            "places. An error of the machine that looks like that shift in every part cannot be told from it: a part "
            "set up at another place of the machine, or turned round, would divide them.",
            parts=len(self.own),
            x=Um(float(self.common.shift_mm[0])),
            y=Um(float(self.common.shift_mm[1])),
            z=Um(float(self.common.shift_mm[2])),
            left=Um(rms(self.left_mm)),
        )


def reconcile_frames(
    part: Integers, point_mm: Array, normal: Array, difference_mm: Array, u_mm: float = 0.001, names: Sequence[str] = ()
) -> Frames:
    """Discrepancies from what the CMM found less what the machine found, (n,) along the normals (n, 3), mm.

    `part` (n,) numbers the parts, `point_mm` (n, 3) are nominal, in the part's frame; points of several parts with the
    same coordinates and normal are the same place. `u_mm` is about what a difference scatters by; `names` are
    those of the parts by their numbers. Findings DIA-MOVED name parts that were moved. Raises DIA-FEW for fewer than
    two parts, MCH-SHAPE for arrays that do not fit.
    """
    numbers = np.unique(part)
    _check(numbers, part, point_mm, normal, difference_mm)
    size = max(float(np.abs(point_mm).max()), 1e-9)
    rows = np.hstack([normal, np.cross(point_mm, normal) / size])
    unit = np.array([1.0] * 3 + [1 / size] * 3)
    unit[np.abs(rows).max(axis=0) < FAINTEST] = np.nan
    alone = {int(k): _alone(rows[part == k], difference_mm[part == k], u_mm) for k in numbers}
    moved = _moved(rows, part, alone, u_mm)
    kept = ~np.isin(part, moved)
    places = _places(point_mm[kept], normal[kept])
    own = [rows[kept] * (part[kept] == k)[:, None] for k in numbers if k not in moved]
    blocks = {
        "common": Block(UM_PER_MM * rows[kept], WIDEST_MM, WIDEST_MM),
        "own": Block(UM_PER_MM * np.hstack(own), LEAST_MM, MOST_MM),
        "place": Block(UM_PER_MM * places, LEAST_MM, MOST_MM),
    }
    fit = mixed(UM_PER_MM * difference_mm[kept], blocks, np.ones(int(kept.sum())), UM_PER_MM * u_mm)
    u = np.sqrt(np.diag(fit.covariance))
    all_u = np.split(u, np.cumsum([6, blocks["own"].rows.shape[1]]))
    common = fit.mean["common"] * WIDEST_MM
    motions = {}
    scaled = fit.mean["own"].reshape(-1, 6) * fit.scales["own"], all_u[1].reshape(-1, 6) * fit.scales["own"]
    for k, mean, its_u in zip([int(k) for k in numbers if k not in moved], *scaled, strict=True):
        motions[k] = _motion(mean, its_u, unit)
    for k in moved:
        motions[k] = _motion(alone[k][0] - common, np.hypot(alone[k][1], all_u[0] * WIDEST_MM), unit)
    left, u_left = np.zeros((2, len(part)))
    left[kept] = places @ fit.mean["place"] * fit.scales["place"]
    u_left[kept] = places @ all_u[2] * fit.scales["place"]
    findings = tuple(
        _finding(names[k] if names else str(k), motions[k], rms(rows[part == k] @ (alone[k][0] - common)))
        for k in moved
    )
    noise = fit.noise / UM_PER_MM
    return Frames(
        common=_motion(common, all_u[0] * WIDEST_MM, unit),
        own=motions,
        left_mm=left,
        u_left_mm=u_left,
        noise_mm=noise,
        moved=moved,
        findings=findings,
    )


def _motion(of: Array, u: Array, unit: Array) -> Motion:
    scaled = np.nan_to_num(of * unit)
    return Motion(scaled[:3], scaled[3:], u * unit)


def _alone(rows: Array, difference_mm: Array, u_mm: float) -> tuple[Array, Array]:
    """A part's whole motion by itself, and its standard uncertainty."""
    covariance = np.linalg.inv(rows.T @ rows / u_mm**2 + np.eye(6) / WIDEST_MM**2)
    return covariance @ rows.T @ difference_mm / u_mm**2, np.sqrt(np.diag(covariance))


def _moved(rows: Array, part: Integers, alone: Mapping[int, tuple[Array, Array]], u_mm: float) -> tuple[int, ...]:
    """Parts whose motion shifts their points by far more than that of the others differs from the middle one."""
    if len(alone) <= LEAST_PARTS:
        return ()
    middle = np.median([motion for motion, _ in alone.values()], axis=0)
    shifted = {k: rms(rows[part == k] @ (motion - middle)) for k, (motion, _) in alone.items()}
    usual = max(float(np.median(list(shifted.values()))), u_mm)
    found = tuple(k for k, size in shifted.items() if size > FAR * usual)
    return found if len(alone) - len(found) >= LEAST_PARTS else ()


def _places(point_mm: Array, normal: Array) -> Array:
    """(n, k): a column a place; none where no place is there twice."""
    _, place = np.unique(np.round(np.hstack([point_mm, normal]), 3), axis=0, return_inverse=True)
    count = int(place.max()) + 1
    if count == len(place):
        return np.zeros((len(place), 0))
    seen: Flags = place.reshape(-1, 1) == np.arange(count)
    return seen.astype(np.float64)


def _finding(part: str, motion: Motion, size_mm: float) -> Finding:
    x, y, z = (UM_PER_MM * motion.shift_mm).tolist()
    return Finding(
        Severity.WARNING,
        Code.DIA_MOVED,
        f"part {part} lies {UM_PER_MM * size_mm:.1f} µm RMS off the frames of the others, a shift of {x:.1f}, {y:.1f}, "
        f"{z:.1f} µm: the part or the probe was moved between the inspections",
        hint="inspect it again on both, or leave it out",
        values={"part": part},
    )


def _check(numbers: Integers, part: Integers, point_mm: Array, normal: Array, difference_mm: Array) -> None:
    counts = [len(part), len(point_mm), len(normal), len(difference_mm)]
    if len(set(counts)) != 1 or not np.isfinite(np.hstack([difference_mm, point_mm.ravel(), normal.ravel()])).all():
        raise Code.MCH_SHAPE.refusal(
            f"parts, points, normals and differences number {counts}, or some are no numbers",
            hint="give each gauging point once in each, in the same order",
            values={"counts": counts},
        )
    if len(numbers) < LEAST_PARTS:
        raise Code.DIA_FEW.refusal(
            f"{len(numbers)} part was inspected on the machine and on the CMM, {LEAST_PARTS} are needed",
            hint="of one part `trueloop machine decompose --new-frame` takes the discrepancy out",
            values={"count": len(numbers), "needed": LEAST_PARTS},
        )
