"""Location and orientation: kept with the datums, or taken out by a best fit.

A best fit takes out what the set-up may have done, and nothing else: of the six motions only those that the points tell
better than the set-up does. On a nearly flat patch three are determined by hardly more than the form itself: a slide of
millimetres would take a good part of a machining pattern with it, and call it location.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code
from trueloop.geometry.surface import Feet, Surface, closest
from trueloop.statistics import rms

ROUNDS: Final = 20
STILL_MM: Final = 1e-9
SETUP_MM: Final = 0.2
"""How far a part that was aligned with its datums may sit off them, where no better value is given."""
BETTER: Final = 3.0
"""A motion as large as the set-up's must stand out of the form by three standard deviations."""
RESOLUTION_MM: Final = 1e-5
"""Points are written with no more digits: a motion is never known finer."""
BENDS: Final = 4
"""Highest degree of the surfaces by which the form's size is judged: bends as wide as those a motion makes."""
STANDS_OFF: Final = 8.0
"""Standard deviations, by the median of the magnitudes, beyond which a point is an outlier."""
LEAST_OFF_MM: Final = 0.05
"""… and so much at least: a smaller local bulge may be form, and moves a fit little."""
NORMAL_MEDIAN: Final = 0.6745
"""Median of the normal distribution's magnitudes, in standard deviations."""
FEW: Final = 0.05
"""A larger share of the points is form, not a chip."""
PARTS: Final = 0.5
"""A component of a unit motion below this is not named."""
UNTOLD_MM: Final = 10.0
"""A motion whose standard uncertainty is larger is not determined: along a plane or a prism the figure is rounding."""
MOTIONS: Final = ("along x", "along y", "along z", "about x", "about y", "about z")


@dataclass(frozen=True, eq=False)
class Alignment:
    """How measured points were brought onto the nominal surface.

    `kind` is "datum" (left where the datums put them) or "best fit". Points fitted are `rotation` @ (p − centre) +
    centre + `shift_mm`; `left` names the motions that were not taken out, with how well the points tell them.
    """

    kind: str
    rotation: Array
    shift_mm: Array
    centre_mm: Array
    left: tuple[str, ...] = ()

    def apply(self, points_mm: Array) -> Array:
        """Points moved as this alignment moves them."""
        return np.asarray((points_mm - self.centre_mm) @ self.rotation.T + self.centre_mm + self.shift_mm)


DATUM: Final = Alignment("datum", np.eye(3), np.zeros(3), np.zeros(3))


@dataclass(frozen=True, eq=False)
class RigidMotions:
    """Effects of small motions of points on their deviations, from the one determined best to the one determined worst.

    `shapes` (n, 6): the deviations each makes, orthonormal; `size` (6,): how much of them a motion of 1 mm makes;
    `motion` (6, 6): the motions, shift and turn, a row each; a turn is in mm at the points' spread.
    """

    shapes: Array
    size: Array
    motion: Array

    def uncertainty_mm(self, form: float) -> Array:
        """Standard deviations of the motions, (6,), where the form makes up `form` of any shape."""
        return form / np.maximum(self.size, 1e-300)


def rigid_motions(points_mm: Array, normal: Array, centre_mm: Array, spread_mm: float) -> RigidMotions:
    """A small turn ω and shift t change a deviation by n·t + ((p − c) × n)·ω, to first order."""
    turns = np.cross((points_mm - centre_mm) / spread_mm, normal)
    return RigidMotions(*np.linalg.svd(np.concatenate([normal, turns], axis=1), full_matrices=False))


def spread_of(points_mm: Array, centre_mm: Array) -> float:
    """Root mean square distance from the centre, mm: by it turns are given in millimetres."""
    return float(np.sqrt(np.mean(np.sum((points_mm - centre_mm) ** 2, axis=1)))) or 1.0


def form_size(motions: RigidMotions, u: Array, v: Array, error_mm: Array) -> float:
    """How much the form makes up of one smooth shape: root mean square over surfaces of low degree over (u, v).

    Errors of form are not independent scatter: they look like motions, and more points do not average them out. What
    motions could have made is taken off first, so that a part that sits badly does not seem ill-formed.
    """
    at = [2 * (k - np.min(k)) / (np.ptp(k) or 1.0) - 1 for k in (u, v)]
    along, across = (np.polynomial.legendre.legvander(k, BENDS) for k in at)
    pairs = [(i, j) for i in range(BENDS + 1) for j in range(BENDS + 1 - i)]
    bends = np.stack([along[:, i] * across[:, j] for i, j in pairs], axis=1)
    made = motions.shapes[:, motions.size > 1e-12 * motions.size[0]]  # a slide along a plane makes nothing
    bends -= made @ (made.T @ bends)
    sizes, shapes = np.linalg.eigh(bends.T @ bends)
    real = sizes > 1e-12 * sizes[-1]
    parts = (shapes.T @ (bends.T @ error_mm))[real] / np.sqrt(sizes[real])
    return max(rms(parts), RESOLUTION_MM)


def count_told(motions: RigidMotions, form: float, setup_mm: float) -> int:
    """How many motions the points determine better than the set-up: those are to be taken out."""
    return int(np.count_nonzero(BETTER * motions.uncertainty_mm(form) <= setup_mm))


@dataclass(frozen=True, eq=False)
class Faces:
    """Faces of one part, and on which of them each point (n,) was measured: they are fitted as one.

    Parameters of several faces say nothing of how far points are apart: `wide` are places in the plane in which the
    points of all spread most.
    """

    surfaces: tuple[Surface, ...]
    face: Integers

    def of(self, kept: Flags) -> "Faces":
        """Returns the faces of some of the points."""
        return Faces(self.surfaces, self.face[kept])

    def closest(self, points_mm: Array, near: tuple[Array, Array] | None = None) -> Feet:
        """Returns the foot of each point on its face."""
        n = len(points_mm)
        u, v, distance, beyond = (np.empty(n) for _ in range(4))
        foot, normal = np.empty((n, 3)), np.empty((n, 3))
        for k, surface in enumerate(self.surfaces):
            here = np.flatnonzero(self.face == k)
            if len(here):
                feet = closest(surface, points_mm[here], None if near is None else (near[0][here], near[1][here]))
                u[here], v[here], distance[here], beyond[here] = feet.u, feet.v, feet.distance_mm, feet.beyond_mm
                foot[here], normal[here] = feet.point_mm, feet.normal
        return Feet(u=u, v=v, point_mm=foot, normal=normal, distance_mm=distance, beyond_mm=beyond)

    def wide(self, feet: Feet) -> tuple[Array, Array]:
        """Returns two coordinates of feet by which form is judged to be wide: parameters of a single face."""
        if len(self.surfaces) == 1:
            return feet.u, feet.v
        off = feet.point_mm - np.mean(feet.point_mm, axis=0)
        _, turned = np.linalg.eigh(off.T @ off)
        return off @ turned[:, 2], off @ turned[:, 1]


def best_fit(
    faces: Faces, points_mm: Array, ball_radius_mm: float, feet: Feet, setup_mm: float = SETUP_MM, name: str = ""
) -> tuple[Alignment, Feet, Flags]:
    """The rigid motion of the points that makes the sum of their squared normal deviations least, their feet then, and
    which points (n,) it leaves out: few that deviate by far more than the others scatter, as on a chip.

    Raises SRF-SETUP for a part that would have to be moved farther than `setup_mm`.
    """
    aside: Flags = np.zeros(len(points_mm), dtype=np.bool_)
    for k in range(ROUNDS):
        kept = ~aside
        of = faces.of(kept)
        own = of.closest(points_mm[kept], (feet.u[kept], feet.v[kept])) if np.any(aside) else feet
        alignment, there, moved_mm = _fitted(of, points_mm[kept], ball_radius_mm, own, setup_mm)
        if np.any(aside):
            there = faces.closest(alignment.apply(points_mm), (feet.u, feet.v))
        error = there.distance_mm - ball_radius_mm
        off = np.abs(error - np.median(error)) > stands_off_mm(error)
        if np.count_nonzero(off) > FEW * len(off):
            off[:] = False
        if np.array_equal(off, aside) or k == ROUNDS - 1:  # the points returned are those that the fit left out
            break
        aside = off
    far = int(np.argmax(np.abs(moved_mm)))
    if abs(moved_mm[far]) > setup_mm:
        raise Code.SRF_SETUP.refusal(
            f"the best fit would move the points of {name!r} by {abs(moved_mm[far]):.3f} mm {MOTIONS[far]}; the set-up "
            f"is off by {setup_mm:g} mm at most",
            hint="an error so large is one of the part, or the part sat worse than that: say how far it may sit off",
            override="gauging.setup_mm in the job",
            values={"part": name, "setup_mm": setup_mm},
        )
    return alignment, there, aside


def stands_off_mm(error_mm: Array) -> float:
    """Returns the deviation from the median beyond which a point is an outlier, by how most of them scatter, mm."""
    scatter = float(np.median(np.abs(error_mm - np.median(error_mm)))) / NORMAL_MEDIAN
    return max(STANDS_OFF * scatter, LEAST_OFF_MM)


def _fitted(
    faces: Faces, points_mm: Array, ball_radius_mm: float, feet: Feet, setup_mm: float
) -> tuple[Alignment, Feet, Array]:
    """The best fit of all of the points, their feet then, and how far it moves them (6,), mm.

    `setup_mm` is how far the set-up may be off: a shift, or what a turn moves the points by in the mean. Motions that
    the points tell worse than to a third of it stay as they are: left out, one costs no more than what the set-up made
    of it; taken out, what the form happens to have of its shape. Gauss–Newton.
    """
    centre = np.mean(points_mm, axis=0)
    spread = spread_of(points_mm, centre)
    alignment, count = Alignment("best fit", np.eye(3), np.zeros(3), centre), 0
    moved_mm = np.zeros(6)
    for _ in range(ROUNDS):
        motions = rigid_motions(alignment.apply(points_mm), feet.normal, centre, spread)
        error = feet.distance_mm - ball_radius_mm
        form = form_size(motions, *faces.wide(feet), error)
        count = max(count, count_told(motions, form, setup_mm))
        step = -(motions.shapes[:, :count].T @ error / motions.size[:count]) @ motions.motion[:count]
        alignment, moved_mm = _moved(alignment, step, spread), moved_mm + step
        feet = faces.closest(alignment.apply(points_mm), (feet.u, feet.v))
        if np.max(np.abs(step)) < STILL_MM:
            break
    left = tuple(
        _named(*each) for each in zip(motions.motion[count:], motions.uncertainty_mm(form)[count:], strict=True)
    )
    return Alignment("best fit", alignment.rotation, alignment.shift_mm, centre, left), feet, moved_mm


def _named(motion: Array, uncertainty_mm: float) -> str:
    """The motion's largest components, and how well the points determine it."""
    parts = [MOTIONS[k] for k in range(6) if abs(motion[k]) > PARTS] or [MOTIONS[int(np.argmax(np.abs(motion)))]]
    known = f"known to {uncertainty_mm:.2g} mm" if uncertainty_mm < UNTOLD_MM else "not determined by the points"
    return f"{' and '.join(parts)} ({known})"


def _moved(alignment: Alignment, step_mm: Array, spread_mm: float) -> Alignment:
    from scipy.spatial.transform import Rotation  # slow to import

    further = Rotation.from_rotvec(step_mm[3:] / spread_mm).as_matrix()
    shift = further @ alignment.shift_mm + step_mm[:3]
    return Alignment("best fit", further @ alignment.rotation, shift, alignment.centre_mm)
