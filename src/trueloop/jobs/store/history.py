"""An edge's parts out of the store, as memory works on them: state is recomputed from records, never kept.

Their order is known from a few words of each; curves and measured values, which take ten times as long to read, are
read of the parts that are wanted.
"""

import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any, Final

from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, EdgeEvent, Identity, InspectionLink, Quarantine, Stage, lives, time_of
from trueloop.domain.record import Correction
from trueloop.domain.tool import Edge
from trueloop.errors import Code, Finding, Severity
from trueloop.geometry.profile import Profile
from trueloop.loops.turned import correction as turned
from trueloop.loops.turned.made_parts import made_part
from trueloop.memory.made_part import CutErrors, MadePart
from trueloop.storage.kinds import joined
from trueloop.storage.store import Kept, Store, find
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging, error_vectors, in_order

NUMBER: Final = re.compile(r"\d+(\.\d+)?")
"""The beginning of a serial number."""


@dataclass(frozen=True)
class Dated:
    """A finish cut with the times of its inspection and its touches, where known. `kept` counts stored cuts."""

    cut: Cut
    inspected_at: datetime | None
    kept: int
    touched_at: datetime | None = None


@dataclass(frozen=True)
class Ordered:
    """Cuts as they are taken to have been made, each with its place in the order, from 0, and whether that is sure."""

    places: tuple[int, ...]
    in_doubt: tuple[bool, ...]


def cutting_order(cuts: Sequence[Dated]) -> Ordered:
    """Orders cuts by the stated order where all have one, else by the time of the cut, of the inspection, of the
    touches, else as they were stored.

    In doubt are cuts that are marked so, and the fewest without which the stated orders, these times and, where no
    order and no time of the cut is stated, the serial numbers agree: a part was inspected before one that is stated
    to have been cut earlier.
    """
    stated = [None if cut.cut.order is None else float(cut.cut.order) for cut in cuts]
    made, inspected = _times([cut.cut.at for cut in cuts]), _times([cut.inspected_at for cut in cuts])
    touched = _times([cut.touched_at for cut in cuts])
    kept: list[float | None] = [float(cut.kept) for cut in cuts]
    base = next(known for known in (stated, made, inspected, touched, kept) if None not in known)
    places = sorted(range(len(cuts)), key=lambda k: (base[k] or 0.0, cuts[k].kept))
    facts = [stated, made, inspected, touched, *([] if base is stated or base is made else [_by_number(cuts)])]
    doubted = {k for by in facts for k in _against([k for k in places if by[k] is not None], by)}
    unordered = base is kept and len(cuts) > 1
    return Ordered(tuple(places), tuple(unordered or k in doubted or cuts[k].cut.order_in_doubt for k in places))


def _times(of: Sequence[datetime | None]) -> list[float | None]:
    return [None if one is None else one.timestamp() for one in of]


def _by_number(cuts: Sequence[Dated]) -> list[float | None]:
    """Serial numbers within a part type rise as parts are made; of several part types they say nothing."""
    kinds = {cut.cut.part.part_type.identity for cut in cuts}
    found = [NUMBER.match(cut.cut.part.serial) for cut in cuts]
    return [None if match is None or len(kinds) > 1 else float(match[0]) for match in found]


def _against(places: Sequence[int], by: Sequence[float | None]) -> set[int]:
    """The fewest whose value has to be left out so that the others do not fall: all but a longest rising sequence."""
    ends: list[float] = []
    reached: list[int] = []
    for k in places:
        value = by[k] or 0.0
        at = bisect_right(ends, value)
        ends[at : at + 1] = [value]
        reached.append(at)
    out, level = set[int](), len(ends) - 1
    for k, at in zip(reversed(places), reversed(reached), strict=True):
        if at == level:
            level -= 1
        else:
            out.add(k)
    return out


def since_mounting(store: Store, edge: Edge, cuts: Sequence[Kept[Cut]]) -> list[Kept[Cut]]:
    """Returns the cuts since the latest mounting of an edge, each with its setting by the events of the edge.

    A new insert of the same designation has another form: what earlier ones cut tells nothing of it. A cut stated to
    be after the edge was turned away or removed is another edge's (EDG-ENDED names it). A cut of unknown time counts as
    long as there was one mounting alone. Without events the cuts are as they were kept.
    """
    return [kept for ago, kept in mountings(store, edge, cuts) if not ago]


def mountings(store: Store, edge: Edge, cuts: Sequence[Kept[Cut]]) -> Iterator[tuple[int, Kept[Cut]]]:
    """Yields cuts as `since_mounting` takes them, of all mountings, each with how many mountings ago it was made."""
    known = lives(kept.value for kept in find(store, EdgeEvent, edge=joined(edge.identity)))
    for kept in cuts:
        at = time_of(kept.value)
        life = next((life for life in reversed(known) if at is not None and life.began <= at), None)
        then = None if at is None or life is None else life.before(at)
        if not known or (at is None and len(known) == 1):
            yield 0, kept
        elif then is not None and life is not None and then.ended is None:
            ago = len(known) - 1 - known.index(life)
            yield ago, replace(kept, value=replace(kept.value, setting=then.setting))


def order_in_doubt(store: Store, cut: Cut, inspected_at: datetime | None) -> Iterator[Finding]:
    """Yields a warning where the stated order and the times of an edge's finish cuts contradict each other."""
    if cut.setting is None:
        return
    edge = joined(cut.setting.edge.identity)
    others = [
        stored for stored in find(store, Cut, edge=edge, stage=Stage.FINISH) if stored.value.identity != cut.identity
    ]
    dated = [Dated(stored.value, _inspected_at(store, stored.value), stored.row) for stored in others]
    dated.append(Dated(cut, inspected_at, max((stored.row for stored in others), default=0) + 1))
    found = cutting_order(dated)
    doubted = [dated[k].cut.part.serial for k, doubt in zip(found.places, found.in_doubt, strict=True) if doubt]
    if doubted:
        yield Finding(
            Severity.WARNING,
            Code.STO_ORDER,
            f"in which order this edge cut {', '.join(map(repr, doubted[:6]))} is in doubt: what is stated, the times "
            "of the inspections and the serial numbers contradict each other, or neither an order nor times are stated",
            hint="state it: --order NUMBER counts the parts of the edge as they were cut",
            values={"serials": doubted[:6]},
        )


def _inspected_at(store: Store, cut: Cut) -> datetime | None:
    found = finish_inspection(store, cut)
    return None if found is None else found.measured_at


REMEMBERED: Final = "turned"
"""Kind of the cuts that memory uses: contours that an edge turned."""


@dataclass(frozen=True)
class LivedPart:
    """A finish cut in the store with its correction and the inspection after it, None while there is none.

    Out of `life_of` both are without what is stored apart. `order_in_doubt`: what is known of when it was cut
    contradicts itself or other parts.
    """

    cut: Cut
    correction: Correction[turned.Correction]
    finish: Inspection | None
    order_in_doubt: bool

    @property
    def of_machine(self) -> bool:
        """Returns whether its correction took known errors of the machine out: then S is of the process alone, so is
        E = F + C where the instrument after the finish cut sees the machine's errors, which the program corrected.
        """
        return bool(self.correction.record.components)

    @property
    def by_own_probe(self) -> bool:
        """Returns whether the machine's own probe inspected the part, as `by_own_probe` has it."""
        return self.finish is not None and by_own_probe(self.correction, self.finish)


def by_own_probe(correction: Correction[Any], finish: Inspection) -> bool:
    """Returns whether the machine's probe, whose error a model told before the cut, inspected the finished part too: it
    misses what repeats [6876 §3.5], and its error is not known any more.
    """
    machine: Any = correction.record.options.get("machine") or {}
    before = {one.device for one in correction.record.inspections if one.device and one.touches}
    return machine.get("touched_on") == "machine" and finish.device in before


def history_of(store: Store, edge: Edge) -> tuple[MadePart, ...]:
    """Returns the parts that an edge finished since it was mounted, in cutting order: without those superseded or
    quarantined, and without parts of which no correction is known; of parts that were corrected for known errors of the
    machine and others those that are as the last is, as their errors differ. `order` counts from 0; `minutes_in_cut` is
    the edge's age as the cut began, None where the time of one of its earlier cuts is not known.

    Raises STO errors, and what the finish inspections refuse.
    """
    life = life_of(store, edge)
    return history_from(
        store, edge, [lived_part for lived_part in life if lived_part.of_machine == life[-1].of_machine]
    )


def history_from(
    store: Store, edge: Edge, life: Sequence[LivedPart], also: Sequence[Cut] = (), wanted: Sequence[int] | None = None
) -> tuple[MadePart, ...]:
    """Returns the history of what `life_of` gave, or of the `wanted` positions; `also`: cuts that are not kept yet."""
    # Minutes in cut of an edge before each of its cuts, as far back as every one of them states its own
    kept = since_mounting(store, edge, _with(find(store, Cut, edge=joined(edge.identity)), also))
    cuts = [stored.value for stored in kept]
    order = cutting_order([Dated(cut, None, row) for row, cut in enumerate(cuts)])
    ages, age = dict[Identity, float](), 0.0
    for cut in (cuts[place] for place in order.places):
        ages[cut.identity] = age
        minutes = cut.conditions.time_in_cut_min
        if minutes is None:
            break
        age += minutes
    return tuple(
        replace(made_of(lived, order), minutes_in_cut=ages.get(lived.cut.identity), order_in_doubt=lived.order_in_doubt)
        for order in (range(len(life)) if wanted is None else wanted)
        for lived in [_whole(store, life[order])]
    )


def _whole(store: Store, lived: LivedPart) -> LivedPart:
    """Returns a part with its curves and measured values."""
    if lived.correction.payload is not None:
        return lived
    (kept,) = find(store, Correction, identity=joined(lived.correction.record.identity))
    return replace(lived, correction=kept.value, finish=finish_inspection(store, lived.cut))


def life_of(store: Store, edge: Edge, also: Sequence[LivedPart] = ()) -> tuple[LivedPart, ...]:
    """Returns an edge's finish cuts since it was mounted, in cutting order, with what is stored about each."""
    given = {lived.cut.identity: lived for lived in also}
    stored = find(store, Cut, edge=joined(edge.identity), stage=Stage.FINISH)
    cuts = since_mounting(store, edge, _with(stored, [lived.cut for lived in also]))
    corrections = _Corrections.of(find(store, Correction, whole=False, edge=joined(edge.identity), product=REMEMBERED))
    found = [
        (kept.row, kept.value, own.correction, own.finish)
        for kept in cuts
        if (own := given.get(kept.value.identity)) is not None
    ]
    found += [
        (kept.row, kept.value, correction, finish_inspection(store, kept.value, whole=False))
        for kept in _not_quarantined(store, [one for one in cuts if one.value.identity not in given])
        if (correction := corrections.of_cut(kept.value)) is not None
    ]
    dated = [
        Dated(cut, None if finish is None else finish.measured_at, row, touched_at(correction))
        for row, cut, correction, finish in found
    ]
    order = cutting_order(dated)
    return tuple(
        LivedPart(cut, correction, finish, in_doubt)
        for place, in_doubt in zip(order.places, order.in_doubt, strict=True)
        for _, cut, correction, finish in [found[place]]
    )


def touched_at(correction: Correction[Any]) -> datetime | None:
    """Returns when the last of what a correction was made from was measured; None: not known of all."""
    times = [inspection.measured_at for inspection in correction.record.inspections]
    return max((time for time in times if time is not None), default=None) if None not in times else None


def finish_inspection(store: Store, cut: Cut, *, whole: bool = True) -> Inspection | None:
    """Returns what a cut left, by the latest of the inspections linked to it: of those before the part left the
    machine, where there are any. The two do not see the same [6876 §3.5]. `whole`: with its values.
    """
    links = {kept.value.inspection: kept.value for kept in find(store, InspectionLink, cut=joined(cut.identity))}
    part = cut.part
    of_part = find(store, Inspection, whole=whole, part_type=part.part_type.name, serial=part.serial) if links else []
    found = [kept.value for kept in of_part if kept.value.identity in links]
    on_machine = [inspection for inspection in found if not links[inspection.identity].released]
    return next(iter(reversed(on_machine or found)), None)


def errors_of(profile: Profile, inspection: Inspection) -> ErrorVectors | None:
    """Returns the part errors at places that an inspection measured; None where it measured none. Raises TCH errors."""
    touches = [matched.touch for matched in match_inspection(profile, inspection).touches]
    if not touches:
        return None
    return error_vectors(profile, in_order(profile, touches), Gauging(z_reference=inspection.z_reference))


def made_of(lived: LivedPart, order: int) -> MadePart:
    """Returns a part of a history: without S where its correction was not made from its touches before the cut."""
    part = made_part(lived.correction.payload, replace(lived.cut, order=order), finish_errors(lived))
    identities = [] if lived.finish is None else [lived.finish.identity]
    own = [
        inspection
        for inspection in lived.correction.record.inspections
        if inspection.part.identity == lived.cut.part.identity
    ]
    if any(inspection.identity not in identities for inspection in own):
        return part
    return replace(part, semifinish=CutErrors.none())


def finish_errors(lived: LivedPart) -> ErrorVectors | None:
    """Returns the part errors that a finish cut left; None where its inspection tells none."""
    if lived.finish is None or lived.by_own_probe:
        return None
    return errors_of(lived.correction.payload.profile, lived.finish)


def whole_of_cut(store: Store, cut: Cut) -> LivedPart | None:
    """Returns a finish cut with its correction and inspection; None of one in quarantine or without a correction."""
    word = quarantine_of(store, cut)
    if cut.setting is None or (word is not None and not word.lifted):
        return None
    edge, serial = joined(cut.setting.edge.identity), cut.part.serial
    made = _Corrections.of(find(store, Correction, whole=False, edge=edge, serial=serial, product=REMEMBERED))
    correction = made.of_cut(cut)
    return None if correction is None else _whole(store, LivedPart(cut, correction, None, False))


@dataclass(frozen=True)
class _Corrections:
    """Corrections without what the loop gave: the latest by its id and by each part that it was made from."""

    by_id: Mapping[str, Correction[Any]]
    by_part: Mapping[Identity, Correction[Any]]

    @classmethod
    def of(cls, corrections: Sequence[Kept[Correction[Any]]]) -> "_Corrections":
        every = [kept.value for kept in corrections]
        of_parts = {part.part.identity: correction for correction in every for part in correction.record.inspections}
        return cls({correction.record.id: correction for correction in every}, of_parts)

    def of_cut(self, cut: Cut) -> Correction[turned.Correction] | None:
        """That which the cut names; of one as programmed the last that was made for its part, whose touches it has."""
        return self.by_id.get(cut.correction) if cut.correction else self.by_part.get(cut.part.identity)


def _not_quarantined(store: Store, cuts: list[Kept[Cut]]) -> Iterator[Kept[Cut]]:
    for kept in cuts:
        word = quarantine_of(store, kept.value)
        if word is None or word.lifted:
            yield kept


def quarantine_of(store: Store, cut: Cut) -> Quarantine | None:
    """Returns the latest statement of whether a cut may teach anything; None: there is none, so it may."""
    words = [stored.value for stored in find(store, Quarantine, cut=joined(cut.identity))]
    return max(words, key=lambda word: word.at, default=None)


def _with(stored: list[Kept[Cut]], also: Sequence[Cut]) -> list[Kept[Cut]]:
    """The stored cuts and those about to be kept, which take the place of stored ones of their identity."""
    rows = {kept.value.identity: kept.row for kept in stored}
    last, new = max(rows.values(), default=0), {cut.identity for cut in also}
    own = [Kept(rows.get(cut.identity, last + 1 + k), cut, datetime.now(UTC)) for k, cut in enumerate(also)]
    return [*(kept for kept in stored if kept.value.identity not in new), *own]
