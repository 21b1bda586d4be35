"""The knowledge of an edge: its form, the transfer to the finish cut, its setting, and the share of each part type.

The state of an edge: the terms of the error (`estimate`) as determined from its parts, one after the other.

Each is a term, or some terms, of the state (`estimate.catalogue`) after all parts behind it.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import radians
from typing import Annotated, Final

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.domain.option import MemoryUse, Option
from trueloop.estimate.catalogue import Catalogue, Sizes, turned_catalogue
from trueloop.estimate.history import History, after_parts
from trueloop.estimate.places import Observed, Places, joined
from trueloop.estimate.sizes import fitted_sizes
from trueloop.estimate.state import State
from trueloop.memory.made_part import CutErrors, MadePart


@dataclass(frozen=True)
class MemoryOptions:
    """The way in which earlier parts of an edge take part in a correction.

    `memory`: "on"; "bands": the correction is today's own fit, earlier parts give only its band; "frozen": nothing is
    learned from parts after `last_part`; "off": earlier parts are not used at all. `first_weight`: share of the
    correction that is applied until one inspected part has confirmed what the actuator does [4773 §2.5].
    """

    memory: Annotated[
        MemoryUse,
        Option(
            "memory.use",
            '`"on"`; `"bands"`: the correction is the fit of today\'s touches, earlier parts give only the band; '
            '`"frozen"`: nothing is learned from parts after `last_part`; `"off"`.',
        ),
    ] = "on"
    last_part: Annotated[
        str, Option("memory.last_part", 'With `"frozen"`: the serial number of the last part that is learned from.')
    ] = ""
    first_weight: Annotated[
        float,
        Option(
            "memory.first_weight",
            "Share of the correction that is applied until an inspected part has confirmed what the machine makes of "
            "a correction.",
            above=0,
            most=1,
        ),
    ] = 0.75
    unseen_rad: Annotated[
        float,
        Option(
            "memory.unseen_deg",
            "How far a contact angle may be from the nearest that was touched or inspected; beyond, nothing is "
            "predicted.",
            above=0,
            most=45,
        ),
    ] = radians(6.0)


IN_FULL: Final = MemoryOptions(first_weight=1.0)
"""Options for contours: a corrected program takes off what it states, read back from it, from the first part on."""


TOOL: Final = "tool"
"""The label of the one tool that a history is of."""

FITTED_PARTS: Final = 8
FITTED_VALUES: Final = 500
"""The largest numbers of latest parts, and of values of these, to which sizes are fitted: enough to determine them."""

WRONG_GAIN: Final = 0.5
"""The standard deviation by which gains differ from 1 where a correction was not run or was entered wrongly."""

ROUND_RAD: Final = 0.1
"""Contact angles are taken to reach a multiple of this, so that the same basis serves part after part."""


@dataclass(frozen=True, eq=False)
class KnownEdge:
    """The state after the parts of a history, and what places of the next part are called in it.

    `age` is the edge's age when the next part is cut, in parts of mean duration. `left_mm`: by part and cut, what all
    terms leave of its values as they are taken in, (n,) each.
    """

    state: State
    part: MadePart
    age: float
    left_mm: tuple[tuple[Array, ...], ...]

    def places(self, errors: CutErrors, finish: bool, taken_off_mm: Array | None = None) -> tuple[Places, Array | None]:
        """Places of a cut of the next part and the functional H of them that its errors are; None: errors at places."""
        return places_of(self.part, self.age, errors, finish, taken_off_mm)


def known_edge(
    history: Sequence[MadePart], part: MadePart, asked: CutErrors | None = None, part_types: Collection[str] = ()
) -> KnownEdge:
    """Returns the state known from earlier parts, in cutting order, before `part`: of its type, edge and setting.

    `asked`: further places to be predicted; `part_types`: further types whose own terms stay in the state.
    """
    parts = [*history, part]
    # The age of its edge at each part, in parts of mean duration, counted from the edge's first of these: by minutes in
    # cut where every part of the edge states them, else by the order of the parts.
    ages = np.zeros(len(parts))
    for edge in {part.edge for part in parts}:
        mine = [k for k, part in enumerate(parts) if part.edge == edge]
        ages[mine] = _ages_of_edge([parts[k] for k in mine])
    every = [errors for made_part in parts for errors in _cuts(made_part)] + ([] if asked is None else [asked])
    angles = np.concatenate([np.zeros(1), *(cut.contact_angle_rad for cut in every)])
    low, high = np.floor(angles.min() / ROUND_RAD), np.ceil(angles.max() / ROUND_RAD)
    catalogue = turned_catalogue(
        ROUND_RAD * float(low),
        ROUND_RAD * float(high),
        several_edges=(len({made_part.edge for made_part in parts}) > 1),
    )
    kept = {"part_type": {part.part_type, *part_types}, "edge": {part.edge}, "setting": {part.setting}}
    found = _LATEST[-1] if _LATEST else None
    if found is None or not found.is_of(history, ages[:-1], catalogue, kept):
        cuts = [observed(made_part, age) for made_part, age in zip(history, ages, strict=False)]
        after = after_parts(catalogue, sizes_of(catalogue, cuts), cuts, kept)
        found = _Learned(tuple(history), ages[:-1], catalogue, kept, after)
        _LATEST[:] = [found]
    left_mm = tuple(tuple(taken.left_mm for taken in of_part) for of_part in found.after.taken)
    return KnownEdge(found.after.state, part, float(ages[-1]), left_mm)


@dataclass(frozen=True, eq=False)
class _Learned:
    """The state after earlier parts of these ages, with what is `kept` of single labels."""

    history: tuple[MadePart, ...]
    ages: Array
    catalogue: Catalogue
    kept: Mapping[str, Collection[str]]
    after: History

    def is_of(
        self, history: Sequence[MadePart], ages: Array, catalogue: Catalogue, kept: Mapping[str, Collection[str]]
    ) -> bool:
        """Returns whether these very parts are behind it."""
        same = catalogue is self.catalogue and kept == self.kept and np.array_equal(ages, self.ages)
        return same and all(made_part is other for made_part, other in zip(history, self.history, strict=True))


_LATEST: Final = list[_Learned]()
"""The latest one at most: alarms, prediction and sources of error of one part follow from one state."""


def observed(part: MadePart, age: float) -> list[Observed]:
    """Returns the touches S of a part, and E = F + C of its finish inspection where C is known; where there are any."""
    found = []
    if len(part.semifinish):
        found.append(cut_of(part, age, part.semifinish, False, None))
    if part.finish is not None and part.correction_mm is not None and len(part.finish):
        found.append(cut_of(part, age, part.finish, True, part.correction_mm))
    return found


def places_of(
    part: MadePart, age: float, errors: CutErrors, finish: bool, taken_off_mm: Array | None = None
) -> tuple[Places, Array | None]:
    """Returns N places of a cut, the reference's last where there is one, and their functional (n, n + 1)."""
    own = _columns(part, age, errors, finish, taken_off_mm)
    if errors.reference is None or errors.z_share is None:
        return own, None
    reference = _columns(part, age, errors.reference, finish, None)
    return joined([own, reference]), np.column_stack([np.eye(len(errors)), -errors.z_share])


def sizes_of(catalogue: Catalogue, cuts: Sequence[Sequence[Observed]]) -> Sizes:
    """Sizes of the terms as the latest parts show them; without any, as believed beforehand."""
    latest: list[Observed] = []
    for part in list(reversed(cuts))[:FITTED_PARTS]:
        if latest and sum(map(len, [*latest, *part])) > FITTED_VALUES:
            break
        latest = [*part, *latest]
    return fitted_sizes(catalogue, latest, [{**catalogue.medians, "gain": WRONG_GAIN}])


def cut_of(part: MadePart, age: float, errors: CutErrors, finish: bool, correction_mm: Array | None) -> Observed:
    """Errors of one cut of a part as observations; `correction_mm` C is added to those of the finish cut."""
    at, functional = places_of(part, age, errors, finish, correction_mm)
    value = errors.error_mm if correction_mm is None else errors.error_mm + correction_mm
    if errors.reference is None or errors.z_share is None:
        return Observed(at, value, errors.standard_u_mm, functional)
    shared = float(errors.reference.standard_u_mm[0]) * errors.z_share
    return Observed(at, value, errors.standard_u_mm, functional, np.outer(shared, shared))


def _columns(part: MadePart, age: float, errors: CutErrors, finish: bool, taken_off_mm: Array | None) -> Places:
    n = len(errors)
    same = {
        "tool": TOOL,
        "edge": part.edge,
        "setting": part.setting,
        "part_type": part.part_type,
        "part": f"{part.order} {part.serial}",
        "age": age,
        "order": part.order,
        "finish": float(finish),
    }
    own = {
        "group": np.array(errors.feature if errors.group is None else errors.group, dtype=object),
        "contact_angle_rad": errors.contact_angle_rad,
        "radius_mm": np.full(n, np.inf),  # a history holds none: the waves over the contact angle follow the axis too
        "z_mm": np.zeros(n) if errors.z_mm is None else errors.z_mm,
        "share": np.full(n, 0.5) if errors.share is None else errors.share,
        "taken_off_mm": np.zeros(n) if taken_off_mm is None else taken_off_mm,
    }
    labels = {
        name: np.full(n, value, dtype=object if isinstance(value, str) else float) for name, value in same.items()
    }
    return Places({**labels, **own})


def _cuts(part: MadePart) -> list[CutErrors]:
    cuts = [part.semifinish] if part.finish is None else [part.semifinish, part.finish]
    return [*cuts, *(cut.reference for cut in cuts if cut.reference is not None)]


def _ages_of_edge(parts: Sequence[MadePart]) -> Array:
    order = np.array([part.order for part in parts], dtype=np.float64)
    minutes = np.array([np.nan if part.minutes_in_cut is None else part.minutes_in_cut for part in parts])
    span = np.ptp(minutes) if np.all(np.isfinite(minutes)) else 0.0
    if span <= 0:
        return np.asarray(order - order.min())
    return np.asarray((minutes - minutes.min()) * (np.ptp(order) / span))


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
