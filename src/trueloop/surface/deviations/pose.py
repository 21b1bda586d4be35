"""The pose of a part whose points are in a frame of their own: from the points and the faces of the CAD model alone.

Even rotations are starts, each improved by closest points (point to plane) on few points; the best poses that differ
are improved on more. A pose counts only where no other explains the points as well, and where the points determine all
six motions: symmetric parts are refused, and the motion that their points leave open is named.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Severity
from trueloop.geometry.surface import Surface, closest
from trueloop.statistics import rms
from trueloop.surface.deviations.alignment import Alignment, named_motion, rigid_motions, spread_of
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from scipy.spatial import KDTree

ModelFace: TypeAlias = tuple[Surface, Callable[[Array, Array], np.ndarray] | None]
"""A face's surface, and which places (u, v) of it are cut away."""

SAMPLES: Final = 12000
"""Places of the model that points are brought to, evenly over its area."""
SIDE: Final = 80
"""Places a side of each face that samples are chosen from."""
STARTS: Final = 300
FEW: Final = 250
MORE: Final = 2500
"""Points that every start is improved on, and that the best ones are."""
KEPT: Final = 16
"""Poses that differ, of the starts, which are improved further."""
TRUSTED: Final = 0.9
"""Share of the points, the nearest ones, that a pose is improved by: others may be of a fixture."""
AS_GOOD: Final = 1.6
"""A pose that leaves less than so many times the best one's distances explains the points as well."""
SHAPES: Final = 16.0
"""Smooth shapes that form errors are taken to consist of, each with as much of their squares."""
DAMPING: Final = 1e-7
TURNED_DEG: Final = 4.0
"""Poses that differ by less are improved as one."""


@dataclass(frozen=True, eq=False)
class Model:
    """Faces of a CAD model, and places on them: points and outward normals (n, 3), and the face of each (n,)."""

    faces: tuple[ModelFace, ...]
    points_mm: Array
    normal: Array
    face: np.ndarray


def model_of_faces(faces: Sequence[ModelFace]) -> Model:
    """Returns a model with places evenly over the area of its faces."""
    found = []
    for number, (surface, trim) in enumerate(faces):
        (u0, u1), (v0, v1) = surface.domain
        share = (np.arange(SIDE) + 0.5) / SIDE  # no place on an edge, where a pole has no normal
        u, v = np.repeat(u0 + (u1 - u0) * share, SIDE), np.tile(v0 + (v1 - v0) * share, SIDE)
        there = np.ones(len(u), np.bool_) if trim is None else ~trim(u, v).astype(np.bool_)
        at = surface.partials(u[there], v[there])
        area = np.linalg.norm(np.cross(at.du, at.dv), axis=1) * (u1 - u0) * (v1 - v0) / SIDE**2
        found.append((at.point_mm, surface.normal_of(at), np.full(len(area), number), area))
    points, normal, face, area = (np.concatenate(column) for column in zip(*found, strict=True))
    some = np.random.default_rng(1).choice(len(area), SAMPLES, p=area / np.sum(area))
    return Model(tuple(faces), points[some], normal[some], face[some])


def found_pose(
    model: Model, points_mm: Array, ball_radius_mm: float, name: str, *, farthest_mm: float, setup_mm: float
) -> tuple[Alignment, Finding]:
    """Returns the motion that brings points (n, 3) into the frame of the model, and a note of it.

    Points are ball centres where `ball_radius_mm` is above 0. Raises SRF-OFF where no pose brings the points to the
    model, SRF-SETUP where several do, or where points leave a motion open by more than `setup_mm`.
    """
    from scipy.spatial import KDTree  # slow to import

    rng = np.random.default_rng(1)
    points = points_mm[rng.choice(len(points_mm), min(MORE, len(points_mm)), replace=False)]
    near = _Near(model, KDTree(model.points_mm + ball_radius_mm * model.normal), ball_radius_mm)
    centre, target = np.mean(points, axis=0), np.mean(model.points_mm, axis=0)
    turns = _even_rotations(STARTS)
    starts = _Poses(turns, np.tile(target - centre, (STARTS, 1)), centre)
    poses = near.improved(points[:FEW], starts, 14)
    poses = poses.some(_different(poses.turn, near.left_mm(points[:FEW], poses, farthest_mm)))
    poses = near.improved(points, poses, 30)
    left = near.left_mm(points, poses, farthest_mm)
    best = int(np.argmin(left))
    alignment = near.finished(points, poses.one(best), farthest_mm)
    moved = alignment.apply(points)
    off, normal = near.exact(moved)
    kept = np.abs(off) <= farthest_mm
    size = rms(off[kept]) if np.any(kept) else np.inf
    if np.mean(kept) < TRUSTED or size > farthest_mm / 4:
        raise Code.SRF_OFF.refusal(
            f"no pose brings {name!r} to the model: in the best of {STARTS} tried, {np.count_nonzero(kept)} of "
            f"{len(points)} points are within {farthest_mm:g} mm, {size * UM_PER_MM:.0f} µm RMS off it",
            hint="look at unit, file and gauging.columns, and take points of fixtures out",
            override="gauging.farthest_mm in the job",
            values={"part": name, "limit_mm": farthest_mm},
        )
    _refuse_symmetric(poses, left, best, moved, name, setup_mm)
    _refuse_open(moved[kept], normal[kept], size, setup_mm, name)
    x, y, z = (np.mean(moved, axis=0) - centre).tolist()
    note = Finding(
        Severity.NOTE,
        Code.SRF_SETUP,
        f"the pose of {name!r} was found from its points: its middle is moved by x {x:.3f}, y {y:.3f}, z {z:.3f} mm, "
        f"turned by {_angle_deg(alignment.rotation):.3f}°; {len(points)} points are then {size * UM_PER_MM:.1f} µm RMS "
        "off the model",
        "look at the maps: deviations that no cut makes come from a wrong pose",
        values={"part": name, "setup_mm": setup_mm},
    )
    return alignment, note


@dataclass(frozen=True, eq=False)
class _Poses:
    """Poses: `turn` (s, 3, 3) about the points' `centre_mm` (3,), then `shift_mm` (s, 3)."""

    turn: Array
    shift_mm: Array
    centre_mm: Array

    def applied(self, points_mm: Array) -> Array:
        """Returns points (k, 3) in all poses, (s, k, 3)."""
        turned = np.einsum("sij,kj->ski", self.turn, points_mm - self.centre_mm)
        return np.asarray(turned + (self.centre_mm + self.shift_mm)[:, None, :])

    def some(self, chosen: np.ndarray) -> "_Poses":
        """Returns some of the poses."""
        return _Poses(self.turn[chosen], self.shift_mm[chosen], self.centre_mm)

    def one(self, chosen: int) -> Alignment:
        """Returns one pose as an alignment."""
        return Alignment("best fit", self.turn[chosen], self.shift_mm[chosen], self.centre_mm)


@dataclass(frozen=True, eq=False)
class _Near:
    """What is nearest to points: places of the model, `tree`, and exact feet on the face of the nearest place."""

    model: Model
    tree: "KDTree"
    ball_mm: float

    def improved(self, points_mm: Array, poses: _Poses, rounds: int) -> _Poses:
        """Returns poses brought nearer to the model, all at once, by planes at the nearest places."""
        spread = spread_of(points_mm, poses.centre_mm)
        for _ in range(rounds):
            moved = poses.applied(points_mm)
            distance, at = self.tree.query(moved)
            normal = self.model.normal[at]
            off = np.einsum("skj,skj->sk", moved - np.asarray(self.tree.data)[at], normal)
            arm = (moved - (poses.centre_mm + poses.shift_mm)[:, None, :]) / spread
            effect = np.concatenate([normal, np.cross(arm, normal)], axis=2)
            weight = distance <= np.quantile(distance, TRUSTED, axis=1)[:, None]
            matrix = np.einsum("sk,ski,skj->sij", weight, effect, effect)
            matrix += DAMPING * np.trace(matrix, axis1=1, axis2=2)[:, None, None] * np.eye(6)
            step = np.linalg.solve(matrix, -np.einsum("sk,ski,sk->si", weight, effect, off)[..., None])[..., 0]
            turn = _rotations(step[:, 3:] / spread) @ poses.turn
            poses = _Poses(turn, poses.shift_mm + step[:, :3], poses.centre_mm)
        return poses

    def left_mm(self, points_mm: Array, poses: _Poses, farthest_mm: float) -> Array:
        """Returns what each pose leaves, (s,): root mean square distances from the planes at the nearest places, each
        counted up to `farthest_mm`.
        """
        moved = poses.applied(points_mm)
        distance, at = self.tree.query(moved)
        off = np.abs(np.einsum("skj,skj->sk", moved - np.asarray(self.tree.data)[at], self.model.normal[at]))
        away = np.sqrt(np.maximum(distance**2 - off**2, 0.0))
        step = float(np.median(self.tree.query(self.tree.data[:FEW], k=[4])[0]))
        off = np.where(away > 3 * step, distance, off)  # beyond the edge of a face
        return np.asarray(np.sqrt(np.mean(np.minimum(off, farthest_mm) ** 2, axis=1)))

    def exact(self, points_mm: Array) -> tuple[Array, Array]:
        """Returns distances (n,) of points in the model's frame, less the ball's radius, and normals (n, 3)."""
        _, at = self.tree.query(points_mm)
        off, normal = np.empty(len(points_mm)), np.empty((len(points_mm), 3))
        for number in np.unique(self.model.face[at]):
            own = self.model.face[at] == number
            feet = closest(self.model.faces[number][0], points_mm[own])
            off[own] = np.where(feet.beyond_mm > 0, np.inf, feet.distance_mm - self.ball_mm)
            normal[own] = feet.normal
        return off, normal

    def finished(self, points_mm: Array, pose: Alignment, farthest_mm: float) -> Alignment:
        """Returns a pose improved on the faces themselves."""
        spread = spread_of(points_mm, pose.centre_mm)
        for _ in range(6):
            moved = pose.apply(points_mm)
            off, normal = self.exact(moved)
            limit = min(farthest_mm, max(6 * float(np.median(np.abs(off))), 0.01))
            kept = np.abs(off) <= limit
            arm = (moved - (pose.centre_mm + pose.shift_mm)) / spread
            effect = np.concatenate([normal, np.cross(arm, normal)], axis=1)[kept]
            step = np.linalg.lstsq(effect, -off[kept], rcond=DAMPING)[0]
            turn = _rotations(step[None, 3:] / spread)[0] @ pose.rotation
            pose = Alignment("best fit", turn, pose.shift_mm + step[:3], pose.centre_mm)
        return pose


def _rotations(vectors: Array) -> Array:
    from scipy.spatial.transform import Rotation  # slow to import

    return np.asarray(Rotation.from_rotvec(vectors).as_matrix())


def _even_rotations(count: int) -> Array:
    """Returns rotations (count, 3, 3), even over all (super-Fibonacci spirals, Alexa 2022)."""
    from scipy.spatial.transform import Rotation  # slow to import

    at = np.arange(count) + 0.5
    a, b, t = 2 * np.pi * at / np.sqrt(2.0), 2 * np.pi * at / 1.533751168755204, at / count
    r, q = np.sqrt(t), np.sqrt(1 - t)
    return np.asarray(
        Rotation.from_quat(np.stack([r * np.sin(a), r * np.cos(a), q * np.sin(b), q * np.cos(b)], 1)).as_matrix()
    )


def _angle_deg(turn: Array) -> float:
    return float(np.degrees(np.arccos(np.clip((np.trace(turn) - 1) / 2, -1.0, 1.0))))


def _different(turns: Array, left_mm: Array) -> np.ndarray:
    """Returns the best poses of which none is another's, `KEPT` at most."""
    chosen: list[int] = []
    for k in np.argsort(left_mm).tolist():
        if all(_angle_deg(turns[k] @ turns[other].T) > TURNED_DEG for other in chosen):
            chosen.append(k)
        if len(chosen) == KEPT:
            break
    return np.array(chosen)


def _refuse_symmetric(poses: _Poses, left_mm: Array, best: int, moved_mm: Array, name: str, setup_mm: float) -> None:
    """Raises SRF-SETUP where another pose explains the points as well: the part looks alike both ways."""
    for k in np.argsort(left_mm).tolist():
        if left_mm[k] > AS_GOOD * left_mm[best]:
            return
        turn = poses.turn[k] @ poses.turn[best].T
        centre = poses.centre_mm + poses.shift_mm[best]
        other = (moved_mm - centre) @ turn.T + poses.centre_mm + poses.shift_mm[k]
        apart = float(np.max(np.linalg.norm(other - moved_mm, axis=1)))
        if _angle_deg(turn) > TURNED_DEG and apart > setup_mm:
            values, vectors = np.linalg.eig(turn)
            axis = np.real(vectors[:, np.argmin(np.abs(values - 1))])
            x, y, z = (axis * np.sign(axis[np.argmax(np.abs(axis))]) + 0.0).tolist()
            raise Code.SRF_SETUP.refusal(
                f"two poses of {name!r} explain its points alike, {left_mm[best] * UM_PER_MM:.1f} and "
                f"{left_mm[k] * UM_PER_MM:.1f} µm RMS: turned by {_angle_deg(turn):.1f}° about ({x:.2f}, {y:.2f}, "
                f'{z:.2f}), {apart:.1f} mm apart at the most; "found" would be a guess',
                hint="the part is symmetric where it was scanned: align it in the scanner's software, and state "
                'gauging.alignment = "best-fit", or scan what tells its sides apart',
                values={"part": name, "setup_mm": setup_mm},
            )


def _refuse_open(points_mm: Array, normal: Array, size_mm: float, setup_mm: float, name: str) -> None:
    """Raises SRF-SETUP where points leave a motion open: they slide on the faces that they are on."""
    centre = np.mean(points_mm, axis=0)
    motions = rigid_motions(points_mm, normal, centre, spread_of(points_mm, centre))
    form = max(size_mm, 1e-4) * np.sqrt(len(points_mm) / SHAPES)
    uncertainty = motions.uncertainty_mm(form)
    free = [named_motion(*each) for each in zip(motions.motion, uncertainty, strict=True) if each[1] > setup_mm]
    if free:
        raise Code.SRF_SETUP.refusal(
            f"the points of {name!r} do not determine its pose: {'; '.join(free)}; {setup_mm:g} mm is the limit",
            hint="scan faces that hold the part in this direction too, or align it in the scanner's software and "
            'state gauging.alignment = "best-fit"',
            override="gauging.setup_mm in the job",
            values={"part": name, "setup_mm": setup_mm},
        )
