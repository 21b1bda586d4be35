"""The knowledge of an edge: its form, the transfer to the finish cut, its setting, and the share of each part type.

Each is a term, or some terms, of the state (`estimate.catalogue`) after all parts behind it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.memory.edge.state import known_edge, places_of
from trueloop.memory.made_part import CutErrors, MadePart

LATEST: Final = 40
"""The largest number of parts used: parts of long ago say little of an edge."""
FORM: Final = ("nose", "nose of the tool", "short nose")
TRANSFER: Final = ("finish level", "finish form", "finish level of the tool", "finish form of the tool")
SETTING: Final = ("setting", "setting of the tool")
OF_TYPE: Final = ("part zero", "finish form of the type", "taper", "form along", "group")
LASTING: Final = (*FORM, *SETTING, *TRANSFER, *OF_TYPE)
"""Terms that a finish cut shares with other parts of its edge, setting and type."""


@by_content
@dataclass(frozen=True)
class Learned:
    """One term at n contact angles: mean (n,) and standard uncertainty (n,), mm; without the scatter of a cut."""

    mean_mm: Array
    u_mm: Array


@by_content
@dataclass(frozen=True)
class Behind:
    """The m errors behind the curves: of which part, whether of its finish cut, at which contact angle (m,).

    `left_mm` (m,) is what all terms together leave of each, mm: added to a curve, it shows how the parts scatter
    about it.
    """

    serial: tuple[str, ...]
    part_type: tuple[str, ...]
    finish: Flags
    contact_angle_rad: Array
    left_mm: Array


@by_content
@dataclass(frozen=True)
class EdgeKnowledge:
    """The knowledge of an edge at n contact angles (n,), after the last of its parts. Errors in mm, positive where
    material is left on.

    `form` is w(φ) with its wear; `transfer` is d(φ), the finish cut's error less the semi-finish cut's. `setting_mm`
    (2,) is o of the present setting along x (a radius) and z, with `setting_u_mm` (2,): at an angle it adds
    o·(sin φ, cos φ). `by_type`: what the finish cut of a part type has besides, by its name. `in_all` is the sum of all
    of them, by part type: the finish error of a next part in the present setting, had nothing been corrected. It is
    known better than its terms, which share offsets. `nearest_rad` (n,) is how far the nearest angle is that was
    touched or inspected. `form_at_mm`, `transfer_at_mm` and `in_all_at_mm` (m,) are the curves at the angles of
    `behind`; `parts` are those behind, `inspected` those with a finish inspection.
    """

    contact_angle_rad: Array
    form: Learned
    transfer: Learned
    setting_mm: Array
    setting_u_mm: Array
    by_type: Mapping[str, Learned]
    in_all: Mapping[str, Learned]
    nearest_rad: Array
    behind: Behind
    form_at_mm: Array
    transfer_at_mm: Array
    in_all_at_mm: Array
    parts: int
    inspected: int


def learnt(history: Sequence[MadePart], contact_angle_rad: Array) -> EdgeKnowledge | None:
    """Returns the terms, given the parts in cutting order, at contact angles (n,) in rad; None without any error.

    An offset that all parts have is shared between setting and part zero. At a contact angle, a part type stands at the
    place of its last part whose angle is the nearest.
    """
    parts = list(history[-LATEST:])
    if not any(len(part.semifinish) or part.uncorrected_mm is not None for part in parts):
        return None
    last, at, types = parts[-1], contact_angle_rad, list(dict.fromkeys(part.part_type for part in parts))
    given = _AllParts(parts, at)
    behind = _behind(parts, given)
    seen = behind.contact_angle_rad

    def in_all(name: str, angle: Array) -> Learned:
        return given.of(LASTING, _like(parts, name, angle), name)

    # At 90° an offset is its x, at 0 its z.
    setting = given.of(SETTING, CutErrors.asked(np.array([np.pi / 2, 0.0])), last.part_type)
    return EdgeKnowledge(
        contact_angle_rad=at,
        form=given.of(FORM, CutErrors.asked(at), last.part_type),
        transfer=given.of(TRANSFER, CutErrors.asked(at), last.part_type),
        setting_mm=setting.mean_mm,
        setting_u_mm=setting.u_mm,
        by_type={name: given.of(OF_TYPE, _like(parts, name, at), name) for name in types},
        in_all={name: in_all(name, at) for name in types},
        nearest_rad=np.min(np.abs(np.subtract.outer(at, seen)), axis=1),
        behind=behind,
        form_at_mm=given.of(FORM, CutErrors.asked(seen), last.part_type).mean_mm,
        transfer_at_mm=given.of(TRANSFER, CutErrors.asked(seen), last.part_type).mean_mm,
        in_all_at_mm=_of_own_type(behind, {name: in_all(name, seen).mean_mm for name in types}),
        parts=len(parts),
        inspected=sum(part.uncorrected_mm is not None for part in parts),
    )


class _AllParts:
    """The state after all parts, and what it left of each of their errors as it was taken in, mm."""

    def __init__(self, parts: Sequence[MadePart], contact_angle_rad: Array) -> None:
        next_part = replace(_bare(parts[-1]), serial="\x00", order=parts[-1].order)
        types = {part.part_type for part in parts}
        self._known = known_edge(parts, next_part, CutErrors.asked(contact_angle_rad), types)
        self.left_mm = np.concatenate([left for part in self._known.left_mm for left in part])

    def of(self, names: Sequence[str], at: CutErrors, part_type: str) -> Learned:
        """Terms together, of the finish cut of a next part."""
        part = replace(self._known.part, part_type=part_type)
        places, functional = places_of(part, self._known.age, at, True)
        found = self._known.state.predict(places, functional, names)
        return Learned(found.mean_mm, found.standard_u_mm)


def _bare(part: MadePart) -> MadePart:
    return replace(part, semifinish=CutErrors.none(), finish=None, correction_mm=None, from_memory_mm=None)


def _behind(parts: Sequence[MadePart], all_parts: _AllParts) -> Behind:
    seen = [(part, finish, errors) for part in parts for finish, errors in _seen(part)]
    counts = [len(errors) for *_, errors in seen]
    serials, types = ([getattr(part, name) for part, *_ in seen] for name in ("serial", "part_type"))
    return Behind(
        tuple(np.repeat(serials, counts).tolist()),
        tuple(np.repeat(types, counts).tolist()),
        np.repeat([finish for _, finish, _ in seen], counts),
        np.concatenate([errors.contact_angle_rad for *_, errors in seen]),
        all_parts.left_mm,
    )


def _seen(part: MadePart) -> list[tuple[bool, CutErrors]]:
    """Returns the cuts of a part that are learned from, in their order, and whether each is of the finish cut."""
    finish = CutErrors.none() if part.finish is None or part.correction_mm is None else part.finish
    return [(of_finish, errors) for of_finish, errors in ((False, part.semifinish), (True, finish)) if len(errors)]


def _like(parts: Sequence[MadePart], part_type: str, contact_angle_rad: Array) -> CutErrors:
    """Places of the type's last part with the nearest contact angles, at these angles; without a reference."""
    (*_, part) = (part for part in parts if part.part_type == part_type)
    cuts = [errors for _, errors in _seen(part)]
    if not cuts:
        return CutErrors.asked(contact_angle_rad)
    nearest = np.argmin(np.abs(np.subtract.outer(contact_angle_rad, cuts[0].contact_angle_rad)), axis=1)
    return replace(cuts[0].chosen(nearest), contact_angle_rad=contact_angle_rad, reference=None, z_share=None)


def _of_own_type(behind: Behind, by_type: Mapping[str, Array]) -> Array:
    """Selects of values by type those of each error's own type."""
    return np.array([by_type[name][k] for k, name in enumerate(behind.part_type)])
