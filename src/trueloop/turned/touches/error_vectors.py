"""Error vectors: the error of the part at every gauging point, along the nominal normal."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from trueloop.arrays import Array, Flags, by_content


@by_content
@dataclass(frozen=True)
class Seen:
    """One reading as it sees the error curves: `value_mm` = Σ weight · e(feature, arc length), arrays of shape (n,).

    `standard_u_mm` is that of the value, from gauging alone; 0: it holds by definition. `value_mm` is a deviation,
    actual − nominal, in mm and of an angle in rad, whose weights then are per mm.
    """

    name: str
    feature_index: NDArray[np.intp]
    arc_length_mm: Array
    weight: Array
    value_mm: float
    standard_u_mm: float
    unit: Literal["mm", "rad"] = "mm"

    @classmethod
    def at(cls, name: str, places: "tuple[tuple[int, float, float], ...]", value_mm: float, u_mm: float) -> "Seen":
        """Of places (feature, arc length, weight)."""
        index, along, weight = zip(*places, strict=True)
        return cls(
            name=name,
            feature_index=np.array(index, dtype=np.intp),
            arc_length_mm=np.array(along),
            weight=np.array(weight),
            value_mm=value_mm,
            standard_u_mm=u_mm,
        )

    def less(self, error_mm: Array) -> "Seen":
        """Returns the functional of the remainder when these errors, (n,) at its places, are taken out."""
        return replace(self, value_mm=self.value_mm - float(self.weight @ error_mm))


@by_content
@dataclass(frozen=True)
class ErrorVectors:
    """Part errors at gauging points, ordered along the profile; all arrays have shape (n,) but the last two (n, 2).

    `error_mm` is `n · (measured − nominal)`: positive = material left on [6876 glossary, PARTERROR]. `standard_u_mm` is
    its standard uncertainty from gauging. `at_reference` marks the points whose error is zero by definition, because
    the part's z was taken from them [6811 §5.1]. `file` is the one the touches were read from; None: from no file.
    `gauged` names the points that are readings of a gauge, as errors at one place; `seen` is what all readings see,
    also those that are of no single place. `by_cmm` names the points that a measuring machine took.
    """

    point: tuple[str, ...]
    feature_index: NDArray[np.intp]
    arc_length_mm: Array
    error_mm: Array
    standard_u_mm: Array
    at_reference: NDArray[np.bool_]
    nominal_mm: Array
    outward_normal: Array
    file: str | None = None
    gauged: tuple[str, ...] = ()
    seen: tuple[Seen, ...] = ()
    by_cmm: tuple[str, ...] = ()

    @property
    def by_gauge(self) -> Flags:
        """Returns which points are readings of a gauge, (n,)."""
        return np.array([name in self.gauged for name in self.point], dtype=np.bool_)

    @property
    def by_probe(self) -> Flags:
        """Returns which points are touches of a probe: neither of a gauge nor of a measuring machine's file, (n,)."""
        others = {*self.gauged, *self.by_cmm}
        return np.array([name not in others for name in self.point], dtype=np.bool_)

    def of_feature(self, index: int) -> NDArray[np.intp]:
        """Positions of the gauging points that lie on feature `index`, in order of arc length."""
        return np.flatnonzero(self.feature_index == index)

    def chosen(self, positions: ArrayLike) -> "ErrorVectors":
        """Returns some of the error vectors, by their positions."""
        k = np.asarray(positions, dtype=np.intp)
        return ErrorVectors(
            point=tuple(self.point[i] for i in k),
            feature_index=self.feature_index[k],
            arc_length_mm=self.arc_length_mm[k],
            error_mm=self.error_mm[k],
            standard_u_mm=self.standard_u_mm[k],
            at_reference=self.at_reference[k],
            nominal_mm=self.nominal_mm[k],
            outward_normal=self.outward_normal[k],
            file=self.file,
            gauged=self.gauged,
            seen=self.seen,
            by_cmm=self.by_cmm,
        )

    @property
    def z_share(self) -> Array:
        """Returns by how much an error falls when the reference touch reads 1 more, (n,): n_z / n_z of the reference.

        Zero at the reference itself, whose error is zero by definition, and everywhere where z has no reference.
        """
        reference = np.flatnonzero(self.at_reference)
        if not len(reference):
            return np.zeros(len(self.point))
        share = self.outward_normal[:, 1] / self.outward_normal[reference[0], 1]
        return np.where(self.at_reference, 0.0, share)

    @property
    def own_u_mm(self) -> Array:
        """Returns the part of `standard_u_mm` that differs by touch, (n,): without the reference point's."""
        reference = np.flatnonzero(self.at_reference)
        if not len(reference):
            return self.standard_u_mm
        k = reference[0]
        shared = self.outward_normal[:, 1] / self.outward_normal[k, 1] * self.standard_u_mm[k]
        own = np.sqrt(np.maximum(self.standard_u_mm**2 - shared**2, 0.0))
        return np.where(self.at_reference, self.standard_u_mm, own)
