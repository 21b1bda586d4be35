"""What a store holds of the series of a part type, recomputed from its records: parts in order, proposals, decisions."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, Identity, InspectionLink, Stage
from trueloop.domain.proposal import PartCutWith, Proposal, ProposalClass, ProposalDecision
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.loops.post_process.flags import few_findings, usable
from trueloop.loops.post_process.options import SeriesOptions
from trueloop.loops.post_process.order import When, cutting_order
from trueloop.loops.post_process.series import PartSeen, series_of, sizes_of
from trueloop.loops.post_process.tracked import Tracked, tracked
from trueloop.storage.kinds import joined
from trueloop.storage.store import Kept, Store, find

AGAIN: Final = "the later inspection counts; the earlier one stays in the store"


@dataclass(frozen=True)
class Book:
    """The series of one part type. `parts` are those that count, in cutting order; `tracked` their series."""

    part_type: str
    parts: tuple[PartSeen, ...]
    tracked: tuple[Tracked, ...]
    proposals: tuple[Proposal, ...]
    decisions: tuple[ProposalDecision, ...]
    findings: tuple[Finding, ...]

    @property
    def by_identity(self) -> Mapping[Identity, Tracked]:
        """Series by what they are known by."""
        return {one.series.identity: one for one in self.tracked}

    def named(self, names: Sequence[str]) -> "Book":
        """With the series of these characteristics alone; () all. Raises SER-UNKNOWN for a name that there is not."""
        known = {one.series.name for one in self.tracked}
        for name in names:
            if name not in known:
                raise TrueloopError(
                    Code.SER_UNKNOWN,
                    f"{name!r} is none of the {len(known)} characteristics of {self.part_type!r}",
                    hint=f"they are: {', '.join(sorted(known))}",
                    values={"characteristic": name},
                )
        return replace(self, tracked=tuple(one for one in self.tracked if not names or one.series.name in names))

    def verdict(self, proposal: Proposal) -> ProposalDecision | None:
        """What was decided of a proposal; None while nothing was."""
        return next((one for one in self.decisions if one.proposal == proposal.id), None)


def part_types(store: Store) -> tuple[str, ...]:
    """Names of the part types of which the store holds inspections with sizes."""
    found = dict.fromkeys(
        kept.value.part.part_type.name for kept in find(store, Inspection) if any(sizes_of(kept.value))
    )
    return tuple(found)


def read_book(store: Store, part_type: str, options: SeriesOptions) -> Book:
    """The series of a part type. Raises SER-UNKNOWN where the store holds none of it."""
    kept = list(_of_finish(store, part_type))
    if not kept:
        raise TrueloopError(
            Code.SER_UNKNOWN,
            f"the store holds 0 inspections with sizes of part type {part_type!r}",
            hint="`trueloop series add` takes inspection files; `trueloop series status` lists the part types",
            values={"characteristic": part_type},
        )
    proposals = tuple(one.value for one in find(store, Proposal, part_type=part_type))
    decisions = _decisions(store, proposals)
    latest, again = _latest(kept)
    seen, findings = _in_order(store, part_type, latest)
    seen = tuple(_with_proposals(store, one, proposals, decisions) for one in seen)
    parts, more = usable([one.seen for one in seen], take_nominal=options.take_nominal)
    series, factors = series_of(parts), _factors(proposals, decisions)
    return Book(
        part_type,
        parts,
        tuple(tracked(one, factors) for one in series),
        proposals,
        decisions,
        (*again, *findings, *more, *few_findings(series)),
    )


@dataclass(frozen=True)
class _Part:
    """An inspection with the part as the loop takes it."""

    kept: Kept[Inspection]
    seen: PartSeen


def _of_finish(store: Store, part_type: str) -> Iterator[Kept[Inspection]]:
    """Inspections with sizes, without those that are linked to an earlier cut than the finish cut."""
    for kept in find(store, Inspection, part_type=part_type):
        if any(sizes_of(kept.value)) and not _before_finish(store, kept.value):
            yield kept


def _before_finish(store: Store, inspection: Inspection) -> bool:
    part = inspection.part
    cuts = find(store, Cut, part_type=part.part_type.name, serial=part.serial)
    links = {
        link.value.inspection: one.value.stage
        for one in cuts
        for link in find(store, InspectionLink, cut=joined(one.value.identity))
    }
    return links.get(inspection.identity, Stage.FINISH) is not Stage.FINISH


def _latest(kept: Sequence[Kept[Inspection]]) -> tuple[list[Kept[Inspection]], list[Finding]]:
    """The latest inspection of each part."""
    by_part: dict[Identity, list[Kept[Inspection]]] = {}
    for one in kept:
        by_part.setdefault(one.value.part.identity, []).append(one)
    findings = [again(of_it[-1].value, len(of_it)) for of_it in by_part.values() if len(of_it) > 1]
    return [of_it[-1] for of_it in by_part.values()], findings


def again(inspection: Inspection, times: int) -> Finding:
    """SER-AGAIN of a part inspected several times."""
    serial = inspection.part.serial
    message = f"part {serial!r} was inspected {times} times"
    return Finding(Severity.NOTE, Code.SER_AGAIN, message, AGAIN, values={"part": serial})


def _in_order(
    store: Store, part_type: str, kept: Sequence[Kept[Inspection]]
) -> tuple[tuple[_Part, ...], tuple[Finding, ...]]:
    cuts = {one.value.part.serial: one.value for one in find(store, Cut, part_type=part_type, stage=Stage.FINISH)}
    whens = [_when(one, k, cuts.get(one.value.part.serial)) for k, one in enumerate(kept)]
    order, findings = cutting_order(whens)
    ordered = [kept[k] for k in order]
    settings = [None if (cut := cuts.get(one.value.part.serial)) is None else cut.setting for one in ordered]
    changed = [
        False,
        *(a != b and a is not None and b is not None for a, b in zip(settings, settings[1:], strict=False)),
    ]
    return tuple(
        _Part(one, PartSeen(one.value, set_before=new)) for one, new in zip(ordered, changed, strict=True)
    ), findings


def _when(kept: Kept[Inspection], place: int, cut: Cut | None) -> When:
    one = kept.value
    if cut is None:
        return When(one.part.serial, place, measured_at=one.measured_at)
    return When(one.part.serial, place, cut.order, cut.at, one.measured_at, cut.order_in_doubt)


def _with_proposals(
    store: Store, part: _Part, proposals: Sequence[Proposal], decisions: Sequence[ProposalDecision]
) -> _Part:
    """The part with what the accepted proposals changed before it was cut."""
    accepted = {one.proposal: one for one in decisions if one.verdict == "accepted"}
    stated = _stated(store, part.kept.value)
    correction: dict[Identity, float] = {}
    anew: set[Identity] = set()
    for proposal in proposals:
        decision = accepted.get(proposal.id)
        if decision is None:
            continue
        if proposal.changes is ProposalClass.MEMORY and proposal.from_serial == part.seen.serial:
            anew |= {effect.series for effect in proposal.effects}
        in_force = _came_after(part.kept, decision) if stated is None else proposal.id in stated
        if proposal.changes is ProposalClass.TOOL_OFFSET and in_force:
            for effect in proposal.effects:
                correction[effect.series] = correction.get(effect.series, 0.0) - effect.size_change_mm
    return _Part(part.kept, replace(part.seen, correction_mm=correction, begin_anew=frozenset(anew)))


def _stated(store: Store, inspection: Inspection) -> tuple[str, ...] | None:
    """The proposals in force as they were stated of an inspection."""
    found = [one.value for one in find(store, PartCutWith) if one.value.inspection == inspection.identity]
    return found[-1].proposals if found else None


def _came_after(kept: Kept[Inspection], decision: ProposalDecision) -> bool:
    """Of inspections for which nothing is stated: whether they were measured, or else kept, after the decision."""
    at = kept.value.measured_at
    return (kept.kept_at if at is None or at.tzinfo is None else at) > decision.at


def _decisions(store: Store, proposals: Sequence[Proposal]) -> tuple[ProposalDecision, ...]:
    ids = {one.id for one in proposals}
    return tuple(one.value for one in find(store, ProposalDecision) if one.value.proposal in ids)


def _factors(proposals: Sequence[Proposal], decisions: Sequence[ProposalDecision]) -> Mapping[Identity, float]:
    """The factor of each series by the weight that was accepted last."""
    by_id, factors = {one.id: one for one in proposals}, dict[Identity, float]()
    for decision in sorted(decisions, key=lambda one: one.at):
        proposal = by_id[decision.proposal]
        if decision.verdict == "accepted" and proposal.weight is not None:
            factors.update(dict.fromkeys((effect.series for effect in proposal.effects), proposal.weight))
    return factors
