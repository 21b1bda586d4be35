"""The history of a tool: parts of a job's edge, and of the edges before it: corners, inserts, earlier mountings."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Final

from trueloop.domain.life import Cut, Stage, time_of
from trueloop.domain.tool import Edge
from trueloop.jobs.store.history import LivedPart, history_from, life_of, made_of, mountings, touched_at, whole_of_cut
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.made_parts import name_of
from trueloop.memory.edge.predict import FIRST, latest_of
from trueloop.memory.made_part import MadePart
from trueloop.storage.kinds import joined
from trueloop.storage.store import Kept, Store, find
from trueloop.wording import wording

LATEST: Final = 12
"""The largest number of parts of earlier edges: what edges share is known from some, and each costs time."""


@dataclass(frozen=True)
class _Earlier:
    """A finish cut by another edge, or by the same one in an earlier mounting, by whose label its part is known."""

    kept: Kept[Cut]
    label: str


def parts_of_earlier_edges(
    store: Store, edge: Edge, own: Sequence[LivedPart], of_machine: bool
) -> tuple[MadePart, ...]:
    """Returns the latest parts that a tool finished by inserts of this designation before the edge cut `own`, in
    cutting order, their `order` below 0.

    Edges in use beside each other (two corners of a grooving insert) are not earlier ones: parts count that were kept
    and cut before the first of `own`. Tools without a name, and inserts without designation, are not known to be
    one tool.
    """
    if not edge.tool.name or not edge.insert:  # a number holds for one machine only
        return ()
    identities = {lived.cut.identity for lived in own}
    cuts = find(store, Cut, edge=joined(edge.identity), stage=Stage.FINISH) if identities else []
    first = min((kept.row for kept in cuts if kept.value.identity in identities), default=None)
    before = min((at for lived in own if (at := _when(lived)) is not None), default=None)
    finished = {(lived.cut.part.part_type.identity, lived.cut.part.serial) for lived in own}
    found = list[tuple[LivedPart, str]]()
    for earlier in sorted(_earlier(store, edge), key=lambda earlier: -earlier.kept.row):
        if len(found) == LATEST:
            break
        part = earlier.kept.value.part
        if (first is not None and earlier.kept.row >= first) or (part.part_type.identity, part.serial) in finished:
            continue
        lived = whole_of_cut(store, earlier.kept.value)
        if lived is None or lived.of_machine != of_machine:
            continue
        at = _when(lived)
        if before is None or at is None or at < before:
            found.append((lived, earlier.label))
    found.reverse()
    return tuple(
        replace(made_of(lived, k - len(found)), edge=label, minutes_in_cut=None)
        for k, (lived, label) in enumerate(found)
    )


def history_of_tool(
    store: Store,
    edge: Edge,
    also: Sequence[LivedPart] = (),
    of_machine: bool | None = None,
    until: tuple[str, str] | None = None,
) -> tuple[MadePart, ...]:
    """Returns the latest parts of earlier edges of a tool, their `order` below 0, and then all of its edge, as
    `history_of` takes these. `also`: parts of the edge as they are about to be kept. `of_machine`: parts that were
    corrected for known errors of the machine, or those that were not; None: as the edge's last. `until`: only the part
    of this type and serial number, where the edge cut it, and those before it by which it is predicted.
    """
    every = life_of(store, edge, also)
    kind = of_machine if of_machine is not None or not every else every[-1].of_machine
    life = [lived_part for lived_part in every if lived_part.of_machine == kind]
    wanted = None
    if until is not None:
        at = _position(life, until)
        wanted = [*_before(life[:at], until[0]), *range(at, len(life))[:1]]
    own = history_from(store, edge, life, [lived.cut for lived in also], wanted)
    return (*parts_of_earlier_edges(store, edge, every, bool(kind)), *own)


def _position(life: Sequence[LivedPart], part: tuple[str, str]) -> int:
    """Returns the position of a part, by its type and serial number; of one that was not cut yet, the end."""
    names = ((name_of(lived_part.cut.part.part_type), lived_part.cut.part.serial) for lived_part in life)
    return next((k for k, name in enumerate(names) if name == part), len(life))


def _before(life: Sequence[LivedPart], part_type: str) -> list[int]:
    """Returns the positions of the parts by which the next one, of this type, is predicted."""
    return latest_of([name_of(lived_part.cut.part.part_type) for lived_part in life], part_type)


def _earlier(store: Store, edge: Edge) -> Iterator[_Earlier]:
    alike = {kept.value.identity: kept.value for kept in find(store, Edge, tool=edge.tool.identity[0])}
    for other in [one for one in alike.values() if one.insert == edge.insert]:
        for ago, kept in mountings(store, other, find(store, Cut, edge=joined(other.identity), stage=Stage.FINISH)):
            label = " ".join(other.identity)
            if other.identity != edge.identity or ago:
                yield _Earlier(kept, f"{label} {ago} mountings ago" if ago else label)


def _when(lived: LivedPart) -> datetime | None:
    inspected = None if lived.finish is None else lived.finish.measured_at
    return time_of(lived.cut) or touched_at(lived.correction) or inspected


def with_history(store: Store, inputs: Inputs) -> Inputs:
    """Returns the job with the parts of its edge that were cut before its own; unchanged where no edge is stated.

    A job that is run again for a part long finished gets what was known then, and gives the same again. Raises STO
    errors.
    """
    if inputs.edge is None or inputs.memory.memory == "off":
        return inputs
    serials = [inspection.part.serial for inspection in inputs.inspections if inspection.part.serial]
    own = (name_of(inputs.part), serials[0] if serials else "")
    edge = inputs.edge
    every = life_of(store, edge)
    life = [lived_part for lived_part in every if lived_part.of_machine == (inputs.machine is not None)]
    inputs = replace(inputs, notes=(*inputs.notes, *_left_out(len(every) - len(life), inputs.machine is not None)))
    before = life[: _position(life, own)]
    earlier = parts_of_earlier_edges(store, edge, every, inputs.machine is not None)
    if not before and not earlier:
        return replace(inputs, notes=(*inputs.notes, FIRST))
    # memory that is frozen after a part looks for it among all
    wanted = range(len(before)) if inputs.memory.memory == "frozen" else _before(before, own[0])
    return replace(inputs, history=(*earlier, *history_from(store, edge, life, (), wanted)))


def _left_out(count: int, of_machine: bool) -> tuple[str, ...]:
    if not count:
        return ()
    if of_machine:
        return (
            wording(
                "Parts of this edge corrected without the machine's known errors: {count}. Their errors contain these.",
                count=count,
            ),
        )
    return (
        wording(
            "Parts of this edge corrected for known errors of the machine: {count}. Today's touches contain these.",
            count=count,
        ),
    )
