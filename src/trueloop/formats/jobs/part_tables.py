"""The tables of a job that state the part: features, curves and characteristics, as the drawing does."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

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
    """The coordinate that it gives: `"x"` of t = z − `origin`, or `"z"` of t = x − `origin`."""
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
    """How far the curve may be from a point. The report states how far it is."""


class FeatureTable(Table):
    """One line, arc or curve, from where the feature before it ended to `to` = [x, z]."""

    name: str
    """Its name, once in a profile: touches refer to it."""
    to: Annotated[Point, In("`unit`")]
    """`[x, z]` where it ends."""
    centre: Annotated[Point | None, In("`unit`")] = None
    """`[x, z]` of an arc's centre."""
    radius: Annotated[Positive | None, In("`unit`")] = None
    """An arc's radius, instead of its centre."""
    turn: Literal["convex", "concave"] = "convex"
    """`"convex"` (dome, edge radius: G02 towards the free end) or `"concave"` (fillet, groove)."""
    more_than_half: bool = False
    """With `radius`: the arc turns through more than 180°."""
    asphere: AsphereTable | None = None
    """An asphere: `[part.feature.asphere]` below. With this or one of the next four keys the feature is a curve."""
    ellipse: EllipseTable | None = None
    """An ellipse: `[part.feature.ellipse]` below."""
    polynomial: PolynomialTable | None = None
    """A polynomial: `[part.feature.polynomial]` below."""
    spline: SplineTable | None = None
    """A B-spline: `[part.feature.spline]` below."""
    points: PointsTable | None = None
    """A list of points with a tolerance: `[part.feature.points]` below."""

    @model_validator(mode="after")
    def _one_form(self) -> "FeatureTable":
        if self.centre is not None and self.radius is not None:
            raise ValueError("an arc has a centre or a radius, not both")
        forms = ("centre", "radius", "asphere", "ellipse", "polynomial", "spline", "points")
        given = [form for form in forms if getattr(self, form) is not None]
        if len(given) > 1:
            raise ValueError(f"a feature has one form, not {' and '.join(given)}")
        return self


class CharacteristicTable(Table):
    """One size that the drawing asks for, to be judged before and after the correction."""

    name: str
    """Its name, once in a job."""
    quantity: Literal["diameter", "length", "angle", "radius", "form"]
    """`"diameter"` (whatever `part.x_is` is), `"length"` (between two faces, or of one from z = 0), `"angle"` (of a
    cone, to the axis), `"radius"` (of an arc) or `"form"` (straightness; of a curve its profile
    deviation, moved along z as a whole).
    """
    feature: str
    """The feature it is of."""
    other: str = ""
    """The second face of a length; left out, it counts from z = 0."""
    at_z_mm: Finite | None = None
    """Where along the feature a diameter holds; left out, everywhere, which a cylinder alone can have."""
    nominal: Annotated[Finite | None, In("`unit`; degrees")] = None
    """As on the drawing; left out, the value of the profile there."""
    tolerance: str | None = None
    """As the drawing states it: `"h6"`, `"±0.02"`, `"+0.01/-0.02"` (in `unit`; degrees of an angle), `"ISO 2768-m"`."""
    lower_limit: Annotated[Finite | None, In("`unit`; degrees")] = None
    """Instead of `tolerance`: the smallest size."""
    upper_limit: Annotated[Finite | None, In("`unit`; degrees")] = None
    """Instead of `tolerance`: the largest size."""

    @model_validator(mode="after")
    def _one_tolerance(self) -> "CharacteristicTable":
        limits = self.lower_limit is not None or self.upper_limit is not None
        if limits == (self.tolerance is not None):
            raise ValueError("a characteristic has a `tolerance`, or a `lower_limit`, an `upper_limit` or both")
        if self.other and self.quantity != "length":
            raise ValueError(f"`other` is of a length: a {self.quantity} has no second face")
        if self.at_z_mm is not None and self.quantity != "diameter":
            raise ValueError(f"`at_z_mm` is of a diameter: a {self.quantity} is of its whole feature")
        return self


class PartTable(Table):
    """The nominal profile: given here, or read from a DXF drawing or a solid, or taken from the finish program."""

    name: str
    """The part's name or number, for the report."""
    revision: str = ""
    """Revision of the drawing. This key and the next three are for the report and the record."""
    material: str = ""
    """Its material."""
    drawing: str = ""
    """Number of its drawing, where that is not its name."""
    serial: str = ""
    """Serial number of the piece that was measured."""
    unit: Literal["mm", "inch"] = "mm"
    """Unit of all coordinates and radii of the profile: `"mm"` or `"inch"` (25.4 mm)."""
    x_is: Literal["radius", "diameter"] = "radius"
    """Meaning of an x coordinate: `"radius"` or `"diameter"`. Arc radii are radii either way."""
    side: Literal["outside", "inside", "around"] = "outside"
    """`"outside"`; `"inside"`: a bore, its features in order from the free end to the chuck end; `"around"`: one
    profile along the outside, over the front face and back through the bore, or a back face alone. The material is
    always on the right of the way along the features, seen with z to the right and x up.
    """
    start: Annotated[Point | None, In("`unit`")] = None
    """`[x, z]` where the first feature begins: of an outside at the chuck end, of a bore at the free end. Start it
    where the finish program's cut has its end there.
    """
    feature: tuple[FeatureTable, ...] = ()
    """The features in order, of an outside from the chuck end to the free end: `[[part.feature]]` below."""
    dxf: Path | None = None
    """A DXF drawing of the part: an open profile, a half section, a section with hatching, a view of both halves, or a
    sheet of them. `side` states whether its outside or its bore is read.
    """
    dxf_layer: str | None = None
    """The layer of the drawing to read, capital letters or not; left out, the whole drawing is."""
    dxf_outline: Count | None = None
    """Which contour, from 1 from the left, where that side has several; the refusal lists them, `trueloop part
    from-dxf --picture` draws them.
    """
    dxf_zero: Literal["drawing", "free-end", "chuck-end"] = "drawing"
    """From where z counts: `"drawing"` (its x = 0; y = 0 of a vertical axis), or the part's `"free-end"` or
    `"chuck-end"` in its view.
    """
    step: Path | None = None
    """A STEP or IGES file of the turned solid: its outside, or its bore by `side`, is the profile, exact, z along its
    axis from the file's origin. What is not turned is left out. Needs the extra `cad`.
    """
    step_outline: Count | None = None
    """Which contour, from 1 from the chuck, where the side has several; the refusal lists them."""
    step_turned_round: bool = False
    """The free end is at the small z of the file: z is counted the other way."""
    step_from_z_mm: Finite | None = None
    """Where the profile begins, as the finish program does; left out, at the solid's end face."""
    step_to_z_mm: Finite | None = None
    """Where it ends; left out, at the other end face."""
    from_program: bool = False
    """Take the profile from the finish program: the path of the nose centre less the nose radius; under G41 or G42 the
    contour that it is.
    """
    general_tolerance: str | None = None
    """`"ISO 2768-m"` (or `f`, `c`, `v`): for every feature without a characteristic, of a cylinder its diameter, of a
    face its length from z = 0, of a cone its angle, of an arc its radius.
    """
    characteristic: tuple[CharacteristicTable, ...] = ()
    """The drawing's characteristics: `[[part.characteristic]]` below."""
    junctions: dict[str, Literal["corner", "tangent"]] = Field(default_factory=dict)
    """Junctions by design, `{ "neck/dome" = "tangent" }` or `"corner"`; the others are found from the geometry."""

    @model_validator(mode="after")
    def _one_source(self) -> "PartTable":
        sources = [bool(self.feature), self.dxf is not None, self.step is not None, self.from_program]
        if sum(sources) != 1:
            raise ValueError("the profile comes from exactly one of `feature`, `dxf`, `step` and `from_program`")
        if self.feature and self.start is None:
            raise ValueError("`start` = [x, z] of the first feature is missing")
        return self
