"""The circular test of ISO 230-4, and the causes of its deviations.

Δ(θ) is the distance of the tool from the centre less the nominal radius, plus: too far out. Deviations are so small
beside the radius that another centre changes them by a cos θ + b sin θ. U is the first axis of the plane, V the second,
θ counts from U towards V.

G of a path is the smallest width of a ring of two concentric circles that holds it, G(b) that of both ways round
together; both are given about the least-squares centre too, as some instruments state them. F are the extremes of Δ
about the least-squares centre of a path, D is the mean of the least-squares radii of both ways less the nominal. F and
D hold the error of the bar's length, G does not.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.errors import Code
from trueloop.machine.identify.observations import orthonormal
from trueloop.units import UM_PER_MM, URAD_PER_RAD


@dataclass(frozen=True)
class Circle:
    """One way round a circle in a plane such as `XY`: angles (n,) rad from its first axis towards its second, in their
    order in time, and length − nominal radius there, mm; `line` is the line of each in its file.
    """

    name: str
    plane: str
    radius_mm: float
    angle_rad: Array
    deviation_mm: Array
    line: Integers

    @property
    def sense(self) -> float:
        """Returns 1 for counter-clockwise as seen against the plane's normal, −1 for clockwise."""
        return float(np.sign(self.angle_rad[-1] - self.angle_rad[0]))

    @property
    def way(self) -> str:
        """Returns ccw or cw."""
        return "ccw" if self.sense > 0 else "cw"

    @property
    def step_rad(self) -> float:
        """Returns the largest step between two angles."""
        return float(np.abs(np.diff(self.angle_rad)).max())

    @property
    def centred_mm(self) -> Array:
        """Returns Δ about the least-squares centre, (n,)."""
        about = _centring(self.angle_rad)
        centre = np.linalg.lstsq(about, self.deviation_mm, rcond=None)[0]
        centred: Array = self.deviation_mm - about[:, :2] @ centre[:2]
        return centred


@dataclass(frozen=True)
class Cause:
    """A cause: its amplitude and expanded uncertainty (k = 2) in `unit`, and the range of Δ that it makes, mm.

    `detail` states what was sought with it: the period of a cyclic error, the length of a spike.
    """

    name: str
    amplitude: float
    expanded_u: float
    unit: str
    range_mm: float
    detail: str = ""

    @property
    def certain(self) -> bool:
        """Returns whether the amplitude is beyond its uncertainty."""
        return abs(self.amplitude) > self.expanded_u


@dataclass(frozen=True)
class CircularTest:
    """The standard's values, mm; by way round (`ccw`, `cw`), NaN for what one way alone does not give.

    `causes` come largest range first; `left_mm` is the RMS of what they and the centre leave.
    """

    circles: tuple[Circle, ...]
    zone_mm: Mapping[str, float]
    about_centre_mm: Mapping[str, float]
    both_zone_mm: float
    both_about_centre_mm: float
    extremes_mm: Mapping[str, tuple[float, float]]
    mean_radial_mm: float
    causes: tuple[Cause, ...]
    left_mm: float

    @property
    def largest(self) -> Cause | None:
        """Returns the cause that makes most of the deviations; None where none is certain."""
        return next((cause for cause in self.causes if cause.certain), None)


FEWEST: Final = 72
"""Angles round a circle below which spikes and reversals fall between them."""


def circular_test(circles: Sequence[Circle]) -> CircularTest:
    """Analyses one circle, or one each way of the same plane and radius. Raises MCH-DATA for other sets."""
    _check(circles)
    by_way = {circle.way: circle for circle in circles}
    blocks = [
        k * 1000 + np.floor(np.abs(circle.angle_rad - circle.angle_rad[0]) / BLOCK_RAD)
        for k, circle in enumerate(circles)
    ]
    both = _Path(
        radius_mm=circles[0].radius_mm,
        angle=np.concatenate([circle.angle_rad for circle in circles]),
        deviation=np.concatenate([circle.deviation_mm for circle in circles]),
        sense=np.concatenate([np.full(len(circle.angle_rad), circle.sense) for circle in circles]),
        block=np.concatenate(blocks),
        step_rad=max(circle.step_rad for circle in circles),
    )
    centred = both.deviation - _centring(both.angle)[:, :2] @ _fit(_centring(both.angle), both.deviation)[:2]
    one_way = len(circles) < 2
    radial = [float(np.mean(_fit(_centring(c.angle_rad), c.deviation_mm)[2])) for c in circles]
    causes, left = _causes(both, circles[0].plane)
    return CircularTest(
        circles=tuple(circles),
        zone_mm={way: _zone(c.angle_rad, c.deviation_mm) for way, c in by_way.items()},
        about_centre_mm={way: float(np.ptp(c.centred_mm)) for way, c in by_way.items()},
        both_zone_mm=np.nan if one_way else _zone(both.angle, both.deviation),
        both_about_centre_mm=np.nan if one_way else float(np.ptp(centred)),
        extremes_mm={way: (float(c.centred_mm.max()), float(c.centred_mm.min())) for way, c in by_way.items()},
        mean_radial_mm=np.nan if one_way else float(np.mean(radial)),
        causes=causes,
        left_mm=left,
    )


def _check(circles: Sequence[Circle]) -> None:
    ways = [circle.way for circle in circles]
    if len(circles) not in (1, 2) or len(set(ways)) < len(ways):
        raise Code.MCH_DATA.refusal(
            f"{len(circles)} circles, {' '.join(ways)}: one is evaluated, or one each way",
            hint="keep one counter-clockwise and one clockwise circle of one set-up in the file",
        )
    if len({(circle.plane, circle.radius_mm) for circle in circles}) > 1:
        raise Code.MCH_DATA.refusal(
            f"{len(circles)} circles of different planes or radii do not make one test",
            hint="a file of its own for each plane and radius",
        )
    for circle in circles:
        swept = float(np.ptp(circle.angle_rad)) + circle.step_rad
        if swept < 2 * np.pi - 1e-6 or len(circle.angle_rad) < FEWEST:
            raise Code.MCH_DATA.refusal(
                f"test {circle.name!r} sweeps {np.degrees(swept):.1f}° with {len(circle.angle_rad)} readings: "
                f"360° and {FEWEST} are needed",
                hint="partial arcs have no F and D, and do not separate the causes: measure whole circles",
            )


def _centring(angle: Array) -> Array:
    return np.column_stack([np.cos(angle), np.sin(angle), np.ones(len(angle))])


def _fit(columns: Array, values: Array) -> Array:
    return np.asarray(np.linalg.lstsq(columns, values, rcond=None)[0], dtype=np.float64)


def _zone(angle: Array, deviation: Array) -> float:
    """Returns the smallest width, over all centres, of a ring that holds the path: a linear programme."""
    from scipy.optimize import linprog

    centre, one = np.column_stack([np.cos(angle), np.sin(angle)]), np.ones((len(angle), 1))
    inside, outside = np.hstack([centre, one, 0 * one]), np.hstack([-centre, 0 * one, -one])
    found = linprog(
        [0, 0, -1, 1], np.vstack([inside, outside]), np.concatenate([deviation, -deviation]), bounds=[(None, None)] * 4
    )
    return float(found["fun"])


@dataclass(frozen=True)
class _Path:
    """Both ways round together: angle, Δ in mm, sense, and the stretch of the path that a reading belongs to."""

    radius_mm: float
    angle: Array
    deviation: Array
    sense: Array
    block: Array
    step_rad: float


BLOCK_RAD: Final = np.radians(15.0)
"""Stretch of a path whose readings are taken to share what no cause explains."""


@dataclass(frozen=True)
class _Kind:
    """A cause as columns (n, 1 or 2) of the amplitude in `unit`, of which `scale` units are a mm or rad."""

    name: str
    unit: str
    scale: float
    columns: Array
    detail: str = ""
    outwards: bool = False


def _causes(path: _Path, plane: str) -> tuple[tuple[Cause, ...], float]:
    """Fits all causes together, and returns them by range, and the RMS left. Cyclic errors and spikes, whose period and
    length are sought, join where they explain what is left; the uncertainty allows for stretches of the path that are
    off together.
    """
    centre = _centring(path.angle)
    tried = [_plain(path, plane, late) for late in product(LATE_STEPS * path.step_rad, repeat=2)]
    kinds = min(tried, key=lambda kinds: _left(np.hstack([centre, *(kind.columns for kind in kinds)]), path.deviation))
    candidates = _sought(path, plane, np.hstack([centre, *(kind.columns for kind in kinds)]))
    while candidates:
        known = orthonormal(np.hstack([centre, *(kind.columns for kind in kinds)]))
        best = max(candidates, key=lambda kind: _explained(kind, known, path.deviation))
        if _explained(best, known, path.deviation) < GAIN:
            break
        kinds.append(best)
        candidates = [kind for kind in candidates if kind.name != best.name]
    whole = np.hstack([centre, *(kind.columns for kind in kinds)])
    amplitude = _fit(whole, path.deviation)
    rest = path.deviation - whole @ amplitude
    # The covariance of the amplitudes: of independent readings or of blocks that are off together, whichever is the
    # larger.
    inverse = np.linalg.pinv(whole.T @ whole)
    plain = inverse * float(rest @ rest) / max(len(rest) - whole.shape[1], 1)
    sums = np.stack([whole[path.block == one].T @ rest[path.block == one] for one in np.unique(path.block)])
    grouped = inverse @ (sums.T @ sums) @ inverse
    larger = np.maximum(np.diag(plain), np.diag(grouped))
    spread = np.sqrt(np.diag(np.diag(larger)))
    found, start = [], centre.shape[1]
    for kind in kinds:
        own = slice(start, start := start + kind.columns.shape[1])
        size = float(amplitude[own][0]) if kind.columns.shape[1] == 1 else float(np.linalg.norm(amplitude[own]))
        made = kind.columns @ amplitude[own]
        u = 2 * kind.scale * float(np.max(spread[own]))
        found.append(
            Cause(
                name=kind.name,
                amplitude=kind.scale * size,
                expanded_u=u,
                unit=kind.unit,
                range_mm=float(np.ptp(made)),
                detail=kind.detail,
            )
        )
    found.sort(key=lambda cause: -cause.range_mm)
    return tuple(found), float(np.sqrt(np.mean(rest**2)))


GAIN: Final = 0.15
"""Share of the sum of squares left by all others that a cyclic error or a spike has to explain in order to count."""


def _left(columns: Array, values: Array) -> float:
    """Returns the sum of squares that the columns leave of the values."""
    basis = orthonormal(columns)
    return float(values @ values - np.sum((basis.T @ values) ** 2))


def _explained(kind: _Kind, known: Array, values: Array) -> float:
    """Returns the share that a cause explains beyond the basis `known`; 0 for spikes inwards: no axis makes these."""
    rest = values - known @ (known.T @ values)
    beside = kind.columns - known @ (known.T @ kind.columns)
    if kind.outwards and float(beside[:, 0] @ rest) <= 0:
        return 0.0
    own = orthonormal(beside)
    return float(np.sum((own.T @ rest) ** 2) / np.sum(rest**2)) if rest.any() else 0.0


LATE_STEPS: Final = np.arange(0.0, 5.0)
"""Steps between readings by which the slide may reverse late: the angle is commanded, and play has to be taken up."""


def _plain(path: _Path, plane: str, late_rad: tuple[float, float]) -> list[_Kind]:
    """Causes that are linear in one amplitude: squareness, scale mismatch, backlash of both axes, which show so much
    after their reversals, servo mismatch.

    Signs: +V leans towards +U; U travels too far against V; an axis lags by half its backlash; U lags more than V.
    """
    c, s, radius = np.cos(path.angle), np.sin(path.angle), path.radius_mm
    first, second = plane[0], plane[1]
    both_ways = bool(np.ptp(path.sense))
    up, right = (
        np.sign(np.round(f(path.angle - path.sense * late), 12))
        for f, late in zip((np.sin, np.cos), late_rad, strict=True)
    )
    square = "squareness" if both_ways else "squareness or servo mismatch"
    kinds = [
        _Kind(square, "µrad", URAD_PER_RAD, (radius * s * c)[:, None]),
        _Kind("scale mismatch", "µm/m", 1e6, (0.5 * radius * np.cos(2 * path.angle))[:, None]),
        _Kind(f"backlash {first}", "µm", UM_PER_MM, (0.5 * path.sense * up * c)[:, None]),
        _Kind(f"backlash {second}", "µm", UM_PER_MM, (-0.5 * path.sense * right * s)[:, None]),
    ]
    if both_ways:
        kinds.append(_Kind("servo mismatch", "µm", UM_PER_MM, (path.sense * s * c)[:, None]))
    return kinds


SHORTEST_STEPS: Final = 2.5
"""Readings that a period holds at least, where the axis moves fastest."""

PERIODS_PER_TURN: Final = 8
"""Frequencies tried for every one that the diameter resolves."""


def _sought(path: _Path, plane: str, plain: Array) -> list[_Kind]:
    """Cyclic errors of either axis by period, spikes after its reversals by length along the path."""
    found = []
    travel = path.radius_mm * np.stack([np.cos(path.angle), np.sin(path.angle)])
    radial = travel / path.radius_mm
    highest = 1 / (SHORTEST_STEPS * path.radius_mm * path.step_rad)
    known = orthonormal(plain)
    frequency = np.arange(1.5 / (2 * path.radius_mm), highest, 1 / (PERIODS_PER_TURN * 2 * path.radius_mm))
    for axis in range(2):
        best = _best_frequency(travel[axis], radial[axis], frequency, known, path.deviation)
        columns = _cyclic(travel[axis], radial[axis], best)
        detail = f"period {1 / best:.3g} mm"
        found.append(_Kind(f"cyclic error {plane[axis]}", "µm", UM_PER_MM, columns, detail))
        since = np.mod(path.sense * (path.angle - 0.5 * np.pi * axis), np.pi)
        for length in SPIKE_STEPS * path.step_rad:
            columns = (np.exp(-since / length) * np.abs(radial[axis]))[:, None]
            detail = f"over {path.radius_mm * length:.2g} mm"
            found.append(_Kind(f"reversal spikes {plane[axis]}", "µm", UM_PER_MM, columns, detail, outwards=True))
    return found


SPIKE_STEPS: Final = np.array([0.5, 1.0, 2.0, 4.0, 8.0])
"""Lengths tried for a spike, in steps between readings."""


def _best_frequency(travel: Array, radial: Array, frequency: Array, columns: Array, values: Array) -> float:
    """Returns the frequency, per mm, of most explanation beyond the basis `columns`, by 2 × 2 normal equations."""
    phase = 2 * np.pi * travel[:, None] * frequency
    rest = values - columns @ (columns.T @ values)
    sine, cosine = (
        wave - columns @ (columns.T @ wave)
        for wave in (np.sin(phase) * radial[:, None], np.cos(phase) * radial[:, None])
    )
    ss, cc, sc = np.sum(sine**2, axis=0), np.sum(cosine**2, axis=0), np.sum(sine * cosine, axis=0)
    s, c = rest @ sine, rest @ cosine
    return float(frequency[int(np.argmax((cc * s**2 - 2 * sc * s * c + ss * c**2) / (ss * cc - sc**2)))])


def _cyclic(travel: Array, radial: Array, frequency: float) -> Array:
    phase = 2 * np.pi * frequency * travel
    return np.column_stack([np.sin(phase) * radial, np.cos(phase) * radial])
