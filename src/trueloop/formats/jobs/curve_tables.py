"""The tables of a job's curved features: the forms in which a drawing states a curve."""

from typing import Annotated, Literal

from pydantic import Field

from trueloop.formats.toml_tables import Count, Finite, In, Positive, Table

Point = tuple[Finite, Finite]
Power = Annotated[int, Field(ge=1, le=40)]


class AsphereTable(Table):
    """The sag of ISO 10110-12, z(h) = h²/(R(1 + √(1 − (1 + k)h²/R²))) + Σ Aᵢ hⁱ, h the distance from the axis."""

    vertex: Annotated[Point, In("`unit`")]
    """`[x, z]` of the vertex, where h = 0: on the spindle axis `[0.0, z]`."""
    radius: Annotated[Finite, In("`unit`")]
    """R at the vertex, a radius whatever `x_is` is. Negative turns the sphere's part of the sag over."""
    conic: Finite = 0.0
    """k: 0 is a sphere, −1 a paraboloid."""
    coefficients: Annotated[dict[Power, Finite], In("`unit`¹⁻ⁱ")] = Field(default_factory=dict)
    """Aᵢ by the power of h: `{ 4 = 2e-6, 6 = -1e-9 }`."""
    sag_towards: Literal["chuck", "free end"] = "chuck"
    """Where a positive sag goes from the vertex: `"chuck"` (a dome at the free end has R > 0) or `"free end"`."""


class EllipseTable(Table):
    """An ellipse; `turn` of the feature says whether it is convex or concave."""

    centre: Annotated[Point, In("`unit`")]
    """`[x, z]` of its centre."""
    semi_axes: Annotated[tuple[Positive, Positive], In("`unit`")]
    """Half its width along x, then along z, both as radii: `[10.0, 20.0]`."""
    rotation_deg: Finite = 0.0
    """By how much both axes are turned, from +z towards +x."""


class PolynomialTable(Table):
    """A polynomial: x of z, or z of x, with x as `x_is` says."""

    coefficients: Annotated[tuple[Finite, ...], Field(min_length=1), In("`unit`¹⁻ⁱ")]
    """`[c0, c1, c2]` of c0 + c1 t + c2 t²."""
    gives: Literal["x", "z"] = "x"
    """What it gives: `"x"` of t = z − `origin`, or `"z"` of t = x − `origin`."""
    origin: Annotated[Finite, In("`unit`")] = 0.0
    """Where t is 0."""


class SplineTable(Table):
    """A B-spline, rational if it has weights."""

    control: Annotated[tuple[Point, ...], Field(min_length=2), In("`unit`")]
    """Its control points `[[x, z], [x, z]]`."""
    knots: tuple[Finite, ...]
    """Its knots, ascending: as many as control points, and `degree` + 1 more."""
    degree: Annotated[Count, Field(le=30)] = 3
    """Its degree."""
    weights: tuple[Positive, ...] = ()
    """A weight for each control point; left out, all are 1."""


class PointsTable(Table):
    """Points, and how far the smooth curve through them may pass from each."""

    through: Annotated[tuple[Point, ...], Field(min_length=1), In("`unit`")]
    """The points `[[x, z], [x, z]]` in order, from where the feature starts to its end; these two need not be in it."""
    tolerance: Annotated[Positive, In("`unit`")]
    """How far the curve may be from a point. The report says how far it is."""
