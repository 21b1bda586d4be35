"""Characteristics of a profile from the tolerances of a STEP file: of which feature each is, and what it limits."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.errors import TrueloopError
from trueloop.formats.cad.step_pmi import Stated
from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.profile import Profile, kind_of
from trueloop.tolerances.text import limits_of
from trueloop.turned.characteristics.measurand import feature_index
from trueloop.turned.characteristics.nominal import checked, edge_of, with_nominal

RADII: Final = ("radius", "spherical radius", "toroidal minor radius")
SAME_DEG: Final = 1e-3
"""An angle that differs by less from the cone's own is the cone's."""


@dataclass(frozen=True)
class Proposals:
    """Characteristics of a profile, and a note of every tolerance of the file that is none, with the reason."""

    characteristics: tuple[Characteristic, ...] = ()
    notes: tuple[str, ...] = ()


def proposals(stated: Sequence[Stated], of_faces: Callable[[Sequence[int]], Sequence[Feature]]) -> Proposals:
    """Proposes characteristics. `of_faces`: the profile's features that faces leave, by their records' numbers."""
    found: list[Characteristic] = []
    notes: list[str] = []
    for one in stated:
        on = [of_faces(faces) for faces in one.faces]
        words = f"{one.kind or 'a dimension'} {_limits(one)}"
        if not on or not all(on):
            notes.append(f"Tolerance left out: {words}, not of this side's turned features.")
            continue
        made = list(_made(one, on))
        if not made:
            names = ", ".join(feature.name for group in on for feature in group)
            notes.append(f"Tolerance left out: {words} of {names}, which a profile does not show.")
        found += [each for each in made if each.name not in {known.name for known in found}]
    return Proposals(tuple(found), tuple(notes))


def fitting(proposed: Sequence[Characteristic], profile: Profile) -> Proposals:
    """Returns the characteristics that a job with this profile accepts; of the others, why not."""
    found: list[Characteristic] = []
    notes: list[str] = []
    for one in proposed:
        try:
            asked = with_nominal(one, one.nominal or None, profile)
            lower, upper = one.lower_limit, one.upper_limit
            if one.tolerance:
                edge = edge_of(profile, feature_index(profile, asked))
                lower, upper = limits_of(one.tolerance, asked.nominal, asked.quantity, edge, 1.0)
            checked(asked, lower, upper, one.tolerance, profile)
            found.append(one)
        except TrueloopError as refused:
            notes.append(f"Tolerance left out: {refused.message}.")
    return Proposals(tuple(found), tuple(notes))


def _made(one: Stated, on: Sequence[Sequence[Feature]]) -> Iterator[Characteristic]:
    first, quantity = on[0][0], _quantity(one, on)
    if quantity is None or (one.lower is None and one.upper is None and not one.fit):
        return
    if quantity is Quantity.LENGTH:
        yield _limited(one, f"{first.name} to {on[1][0].name}", quantity, first.name, other=on[1][0].name)
        return
    for feature in on[0]:
        stated = _to_the_axis(one, feature) if quantity is Quantity.ANGLE else one
        if stated is not None:
            yield _limited(stated, f"{feature.name} {quantity}", quantity, feature.name)


def _to_the_axis(one: Stated, cone: Feature) -> Stated | None:
    """An angle of a cone counted to the axis: a file may say the cone's own, which is twice that."""
    along_x, along_z = (abs(float(part)) for part in cone.tangent(0.0))
    has = math.degrees(math.atan2(along_x, along_z))
    for factor in (1.0, 0.5):
        if one.nominal is not None and abs(one.nominal * factor - has) < SAME_DEG:
            low, high = (None if size is None else size * factor for size in (one.lower, one.upper))
            return replace(one, nominal=one.nominal * factor, lower=low, upper=high)
    return None


def _quantity(one: Stated, on: Sequence[Sequence[Feature]]) -> Quantity | None:
    """What a dimension of the file is on the profile; None of one that the profile does not show."""
    kinds = {kind_of(feature) for group in on for feature in group}
    if one.kind == "diameter" and kinds == {"cylinder"}:
        return Quantity.DIAMETER
    if one.kind in RADII and kinds == {"arc"}:
        return Quantity.RADIUS
    if one.kind == "angle" and kinds == {"cone"} and len(on) == 1:
        return Quantity.ANGLE
    if one.kind == "linear distance" and kinds == {"face"} and len(on) == 2:
        return Quantity.LENGTH
    if one.kind == "straightness" and all(not isinstance(feature, Arc) for feature in on[0]):
        return Quantity.FORM
    return None


def _limited(one: Stated, name: str, quantity: Quantity, feature: str, other: str = "") -> Characteristic:
    return Characteristic(name, quantity, feature, one.nominal or 0.0, one.lower, one.upper, other, tolerance=one.fit)


def _limits(one: Stated) -> str:
    nominal = "" if one.nominal is None else f"{one.nominal:.4f} "
    limits = " to ".join("…" if value is None else f"{value:.4f}" for value in (one.lower, one.upper))
    return nominal + (one.fit or (limits if limits != "… to …" else "without limits"))
