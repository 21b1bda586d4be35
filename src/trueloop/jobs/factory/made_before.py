"""Corrections of a person's program that the store has, among which what cut the next part is chosen."""

from collections.abc import Mapping, Sequence
from typing import Any

from trueloop.domain.life import Ran
from trueloop.domain.record import Correction as StoredCorrection
from trueloop.errors import Code
from trueloop.factory.views.by_hand import MadeBefore, Way
from trueloop.jobs.factory.hand_job import AskedPart, AskedReadings
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.in_force import keeps_wear
from trueloop.nc.program.called import Called
from trueloop.storage.store import Store, find


def made_before(store: Store, part: AskedPart, tools: Sequence[str] = ()) -> tuple[MadeBefore, ...]:
    """Returns the corrections of a part's program that the store has, the latest first.

    Those of another tool than the part's, or than `tools`, which the program calls, are left out.
    """
    found = [
        MadeBefore(
            one.record.id,
            one.record.made_at,
            next((of.part.serial for of in one.record.inspections if of.part.serial), ""),
            ways_of(one.payload),
            _tool_of(one.payload),
        )
        for one in reversed(_before(store, part.program))
        if isinstance(one.payload, Correction)
    ]
    return tuple(one for one in found if _may_be_of(one.tool, part.tool, tools))


def _before(store: Store, sha256: str) -> list[StoredCorrection[Any]]:
    return [one.value for one in find(store, StoredCorrection, program_sha256=sha256)]


def name_before(store: Store, sha256: str) -> str:
    """Returns the name of the part type of the first correction of a program, by its hash; "" before that."""
    types = (one.record.part_type for one in _before(store, sha256))
    return next((one.name for one in types if one is not None), "")


def _tool_of(of: Correction) -> str:
    """The edge that a correction is of, as programs call it; "" where neither job nor program states it."""
    edge, wear = of.record.options.get("edge"), of.wear
    if isinstance(edge, str):
        return edge
    return Called(wear.tool, wear.edge).words if wear.tool else ""


def _may_be_of(tool: str, stated: int | None, tools: Sequence[str]) -> bool:
    """Whether a correction of that tool can have cut a part of the tool stated, else of one of those called."""
    words = tool.partition(" (")[0]
    if not words or (stated is None and not tools):
        return True
    return words in tools if stated is None else words.partition(" ")[0] == f"T{stated}"


def require_all_shown(store: Store, part: AskedPart, measured: AskedReadings | None, tools: Sequence[str]) -> None:
    """Refuses a statement of what cut the part by somebody who was not shown all corrections that may have.

    Raises CMP-CUT-WITH.
    """
    if measured is None or not measured.cut_with:
        return
    unseen = [one for one in made_before(store, part, tools) if one.id not in measured.made_before]
    if unseen:
        raise Code.CMP_CUT_WITH.refusal(
            f"correction {unseen[0].id} of this program was made since the part was shown, on {unseen[0].made_at[:16]}",
            hint="show the part again, and choose among all of its corrections what cut this part",
            values={"corrections": [one.id for one in unseen]},
        )


def ways_of(of: Correction) -> tuple[Way, ...]:
    """Returns the ways of carrying a correction out, the recommended one first; a program may set an offset, too."""
    beside = of.by_tool is not None and of.by_tool.comes_first and of.options.by == "auto"
    enters = of.wear.tool and keeps_wear(of.record)
    wear: list[Way] = ["wear"] if enters and (of.decision.by_offset or beside) else []
    recommended: Mapping[Ran, Way] = {Ran.WEAR: "wear", Ran.OFFSETS: "offsets", Ran.CORRECTED: "corrected"}
    way = recommended[of.recommended]
    return tuple(dict.fromkeys([*wear, way] if of.decision.by_offset else [way, *wear]))
