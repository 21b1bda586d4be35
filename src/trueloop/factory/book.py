"""The series of a part type in a store, recomputed from records: parts in order, proposals, decisions."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, Identity, InspectionLink, Quarantine, Stage
from trueloop.domain.proposal import PartCutWith, Proposal, ProposalDecision
from trueloop.errors import Code, Finding, Severity
from trueloop.loops.post_process.decide import few_findings, usable
from trueloop.loops.post_process.series import PartSeen, SeriesOptions, When, parts_in_order, series_of, sizes_of
from trueloop.loops.post_process.tracked import TrackedSeries, tracked
from trueloop.storage.store import Kept, Store, find

AGAIN: Final = "the later inspection counts; the earlier one stays in the store"


@dataclass(frozen=True)
class Book:
    """The series of one part type. `parts` are those that count, in cutting order; `tracked` their series."""

    part_type: str
    parts: tuple[PartSeen, ...]
    tracked: tuple[TrackedSeries, ...]
    proposals: tuple[Proposal, ...]
    decisions: tuple[ProposalDecision, ...]
    findings: tuple[Finding, ...]

    @property
    def by_identity(self) -> Mapping[Identity, TrackedSeries]:
        """Series by what they are known by."""
        return {series.series.identity: series for series in self.tracked}

    def named(self, names: Sequence[str]) -> "Book":
        """Returns the book of these characteristics alone; () all. Raises SER-UNKNOWN for an unknown name."""
        known = {series.series.name for series in self.tracked}
        for name in names:
            if name not in known:
                raise Code.SER_UNKNOWN.refusal(
                    f"{name!r} is not one of the {len(known)} characteristics of {self.part_type!r}",
                    hint=f"they are: {', '.join(sorted(known))}",
                    values={"characteristic": name},
                )
        return replace(
            self, tracked=tuple(series for series in self.tracked if not names or series.series.name in names)
        )

    @property
    def waiting(self) -> tuple[Proposal, ...]:
        """Proposals that hold now, and of which nothing was decided: a later part supersedes them."""
        now = self.by_identity
        return tuple(
            proposal
            for proposal in self.proposals
            if self.verdict(proposal) is None
            and all(
                (series := now.get(effect.series)) is not None
                and len(series.parts) == effect.parts
                and series.in_force_mm == effect.in_force_mm
                for effect in proposal.effects
            )
        )

    def verdict(self, proposal: Proposal) -> ProposalDecision | None:
        """Returns what was decided of a proposal; None while nothing was."""
        return next((decision for decision in self.decisions if decision.proposal == proposal.id), None)


def part_types(store: Store) -> tuple[str, ...]:
    """Names of the part types of which the store holds inspections with sizes."""
    found = dict.fromkeys(
        kept.value.part.part_type.name for kept in find(store, Inspection) if any(sizes_of(kept.value))
    )
    return tuple(found)


def only_type(store: Store) -> str:
    """Returns the part type of a store that has one alone. Raises SER-UNKNOWN where it has none, or several."""
    found = part_types(store)
    if len(found) == 1:
        return found[0]
    listed = ", ".join(map(repr, found)) or "none"
    raise Code.SER_UNKNOWN.refusal(
        f"the store holds inspections with sizes of {len(found)} part types: {listed}",
        hint="say which: `--type NAME`; `trueloop series add` takes inspection files",
        values={"characteristic": listed},
    )


def read_book(store: Store, part_type: str, options: SeriesOptions) -> Book:
    """Reads the series of a part type. Raises SER-UNKNOWN where the store holds none of it."""
    records = _read(store, part_type)
    if not records.inspections:
        raise Code.SER_UNKNOWN.refusal(
            f"the store holds 0 inspections with sizes of part type {part_type!r}",
            hint="`trueloop series add` takes inspection files; `trueloop series status` lists the part types",
            values={"characteristic": part_type},
        )
    latest, again = _latest(records.inspections)
    seen, doubts = records.in_order(latest)
    parts, odd = usable(seen, take_nominal=options.take_nominal)
    series, factors = series_of(parts), records.factors
    return Book(
        part_type=part_type,
        parts=parts,
        tracked=tuple(tracked(one, factors, records.in_force_mm) for one in series),
        proposals=records.proposals,
        decisions=records.decisions,
        findings=(*again, *doubts, *odd, *few_findings(series)),
    )


def _latest(kept: Sequence[Kept[Inspection]]) -> tuple[list[Kept[Inspection]], list[Finding]]:
    """The latest inspection of each part."""
    by_part: dict[Identity, list[Kept[Inspection]]] = {}
    for stored in kept:
        by_part.setdefault(stored.value.part.identity, []).append(stored)
    findings = [inspected_again(of_it[-1].value, len(of_it)) for of_it in by_part.values() if len(of_it) > 1]
    return [of_it[-1] for of_it in by_part.values()], findings


def inspected_again(inspection: Inspection, times: int) -> Finding:
    """Makes the finding SER-AGAIN of a part inspected several times."""
    serial = inspection.part.serial
    message = f"part {serial!r} was inspected {times} times"
    return Finding(Severity.NOTE, Code.SER_AGAIN, message, AGAIN, values={"part": serial})


@dataclass(frozen=True)
class _Records:
    """The stored facts of a part type: `cuts` are finish cuts by serial number, `stated` by inspection."""

    inspections: tuple[Kept[Inspection], ...]
    cuts: Mapping[str, Cut]
    quarantined: frozenset[Identity]
    proposals: tuple[Proposal, ...]
    decisions: tuple[ProposalDecision, ...]
    stated: Mapping[Identity, tuple[str, ...]]

    @property
    def accepted(self) -> Mapping[str, ProposalDecision]:
        """Decisions by proposal, of those accepted."""
        return {decision.proposal: decision for decision in self.decisions if decision.verdict == "accepted"}

    @property
    def factors(self) -> Mapping[Identity, float]:
        """Returns the factor of each series by the weight that was accepted last."""
        by_id, factors = {one.id: one for one in self.proposals}, dict[Identity, float]()
        for decision in sorted(self.accepted.values(), key=lambda one: one.at):
            proposal = by_id[decision.proposal]
            if proposal.weight is not None:
                factors.update(dict.fromkeys((effect.series for effect in proposal.effects), proposal.weight))
        return factors

    @property
    def in_force_mm(self) -> Mapping[Identity, float]:
        """Returns what all accepted proposals take off, mm, by series."""
        taken: dict[Identity, float] = {}
        for proposal in self.proposals:
            for effect in proposal.effects if proposal.id in self.accepted else ():
                taken[effect.series] = taken.get(effect.series, 0.0) - effect.size_change_mm
        return taken

    def in_order(self, kept: Sequence[Kept[Inspection]]) -> tuple[tuple[PartSeen, ...], tuple[Finding, ...]]:
        """Returns the parts as they were cut, each with what was in force, and what is in doubt of their order."""
        order, findings = parts_in_order([self._when(stored, k) for k, stored in enumerate(kept)])
        seen: list[PartSeen] = []
        before: Cut | None = None
        for stored in (kept[k] for k in order):
            cut = self.cuts.get(stored.value.part.serial)
            anew = before is not None and cut is not None and before.setting != cut.setting
            seen.append(self._seen(stored, set_before=anew, counts=cut is None or cut.identity not in self.quarantined))
            before = cut or before
        return tuple(seen), findings

    def _when(self, kept: Kept[Inspection], place: int) -> When:
        one = kept.value
        cut = self.cuts.get(one.part.serial)
        if cut is None:
            return When(one.part.serial, place, measured_at=one.measured_at)
        return When(
            serial=one.part.serial,
            kept=place,
            cut_order=cut.order,
            cut_at=cut.at,
            measured_at=one.measured_at,
            in_doubt=cut.order_in_doubt,
        )

    def _seen(self, kept: Kept[Inspection], *, set_before: bool, counts: bool) -> PartSeen:
        """The part with what the accepted proposals changed before it was cut."""
        correction: dict[Identity, float] = {}
        anew: set[Identity] = set()
        stated, accepted = self.stated.get(kept.value.identity), self.accepted
        for proposal in self.proposals:
            decision = accepted.get(proposal.id)
            if decision is None:
                continue
            if proposal.from_serial and proposal.from_serial == kept.value.part.serial:
                anew |= {effect.series for effect in proposal.effects}
            in_force = came_after(kept, decision) if stated is None else proposal.id in stated
            for effect in proposal.effects if in_force else ():
                correction[effect.series] = correction.get(effect.series, 0.0) - effect.size_change_mm
        return PartSeen(kept.value, correction, set_before, counts, frozenset(anew))


def came_after(kept: Kept[Inspection], decision: ProposalDecision) -> bool:
    """Returns whether an inspection for which nothing is stated was measured, or else kept, after the decision."""
    at = kept.value.measured_at
    return (kept.kept_at if at is None or at.tzinfo is None else at) > decision.at


def _read(store: Store, part_type: str) -> _Records:
    cuts = [stored.value for stored in find(store, Cut, part_type=part_type)]
    early = {cut.identity for cut in cuts if cut.stage is not Stage.FINISH}
    of_early = (
        {stored.value.inspection for stored in find(store, InspectionLink) if stored.value.cut in early}
        if early
        else set()
    )
    proposals = tuple(stored.value for stored in find(store, Proposal, part_type=part_type))
    ids = {proposal.id for proposal in proposals}
    return _Records(
        inspections=tuple(
            stored
            for stored in find(store, Inspection, part_type=part_type)
            if stored.value.identity not in of_early and any(sizes_of(stored.value))
        ),
        cuts={cut.part.serial: cut for cut in cuts if cut.stage is Stage.FINISH},
        quarantined=frozenset(_quarantined(store)) if cuts else frozenset(),
        proposals=proposals,
        decisions=tuple(stored.value for stored in find(store, ProposalDecision) if stored.value.proposal in ids),
        stated={stored.value.inspection: stored.value.proposals for stored in find(store, PartCutWith)} if ids else {},
    )


def _quarantined(store: Store) -> Iterator[Identity]:
    """Cuts that are to teach nothing: of each the latest word counts."""
    words = sorted((stored.value for stored in find(store, Quarantine)), key=lambda quarantine: quarantine.at)
    latest = {word.cut: word.lifted for word in words}
    yield from (cut for cut, lifted in latest.items() if not lifted)
