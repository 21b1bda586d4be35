"""Names what a solid has that is not turned about its axis: cross holes, holes along it, flats and keyways."""

from collections.abc import Iterator, Sequence

import numpy as np

from trueloop.formats.cad.axis import Axis
from trueloop.formats.cad.bodies import Body
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.step import CadFace
from trueloop.formats.cad.turned_faces import edge_places, meridians, run_on
from trueloop.geometry.feature import Feature


def not_turned(body: Body, axis: Axis, section: Sequence[Feature]) -> Iterator[str]:
    """Yields a note on every kind of face that leaves nothing in the section, with their number and place."""
    groups: dict[str, list[tuple[float, float]]] = {}
    for face in body.faces:
        if run_on(meridians(face, axis), section):
            continue
        z = [at[1] for at in edge_places(face, axis)]
        groups.setdefault(_named(face, axis), []).append((min(z), max(z)) if z else (0.0, 0.0))
    for name, reach in groups.items():
        low, high = min(a for a, _ in reach), max(b for _, b in reach)
        faces = "1 face" if len(reach) == 1 else f"{len(reach)} faces"
        yield f"Not turned, left out: {name}, {faces} between z = {low:.3f} and z = {high:.3f} mm."


def _named(face: CadFace, axis: Axis) -> str:
    surface = kernel().surface_of(face.handle)
    if face.kind == "CylindricalSurface":
        direction = surface.Axis().Direction()
        if axis.is_parallel(direction):
            x = axis.flat(surface.Axis().Location())[0]
            return f"hole or round of radius {surface.Radius():.3f} mm along the axis, {x:.3f} mm from it"
        return f"cross hole or round of radius {surface.Radius():.3f} mm"
    if face.kind == "Plane":
        direction = surface.Axis().Direction()
        normal = np.array([direction.X(), direction.Y(), direction.Z()])
        along = abs(float(normal @ axis.direction)) < 1e-6
        return "planes along the axis (flats, keyways)" if along else "planes across the axis or oblique"
    return {"BSplineSurface": "B-spline surfaces (threads, free forms)"}.get(face.kind, face.kind)
