"""Proposals as they are shown, with why one may not be accepted now."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

from trueloop.domain.part import Part
from trueloop.domain.proposal import Effect, Proposal, ProposalDecision
from trueloop.domain.record import Product
from trueloop.errors import TrueloopError
from trueloop.factory.book import Book, read_book
from trueloop.factory.known import unknown
from trueloop.factory.load import Known
from trueloop.factory.shown.paging import known_of
from trueloop.factory.views.series import EffectView, ProposalView
from trueloop.loops.post_process.decide import decide
from trueloop.loops.post_process.options import SeriesOptions
from trueloop.report.dark import in_the_dark
from trueloop.report.series.proposal_figure import proposal_figure
from trueloop.report.still import svg
from trueloop.report.texts.texts import Texts
from trueloop.storage.life import life
from trueloop.storage.store import Store
from trueloop.units import UM_PER_MM


def proposal_views(store: Store, now: datetime, state: str | None = None) -> tuple[ProposalView, ...]:
    """All proposals of a state, the latest first; of those that are open, why one may not be accepted now."""
    with known_of(store) as known:
        every = states_of(known)
    chosen = [one for one in every if state is None or one[1] == state]
    books = {
        name: read_book(store, name, SeriesOptions())
        for name in {one[0].part_type.name for one in chosen if one[1] == "open"}
    }
    return tuple(_view(*one, books.get(one[0].part_type.name), now) for one in reversed(chosen))


def proposal_view(store: Store, number: str, now: datetime) -> ProposalView:
    """One proposal by its id, with the corrections that the last part behind it was cut by. Raises FAC-UNKNOWN."""
    found = next((one for one in proposal_views(store, now) if one.id == number), None)
    if found is None:
        raise _unknown(number)
    last = _proposal(store, number)
    records = life(store, Part(last.part_type, last.last_serial)).corrections
    made = tuple(one.value.id for one in records if one.value.product is Product.TURNED)
    return replace(found, last_serial=last.last_serial, corrections=made)


def proposal_picture(store: Store, number: str, say: Texts, *, dark: bool) -> str:
    """What it does to the next part, as a picture (SVG). Raises FAC-UNKNOWN."""
    title = say("What the proposal does to the next part: errors without it and with it, ± 95 %")
    drawn = svg(proposal_figure(_proposal(store, number).effects, say), title)
    return in_the_dark(drawn) if dark else drawn


def _proposal(store: Store, number: str) -> Proposal:
    with known_of(store) as known:
        found: Proposal | None = known.first(Proposal, number)
    if found is None:
        raise _unknown(number)
    return found


def _unknown(number: str) -> TrueloopError:
    return unknown("proposal", number, "the store has none of that id")


def states_of(known: Known) -> Sequence[tuple[Proposal, str, ProposalDecision | None]]:
    """Every proposal with open, accepted, rejected or superseded, oldest first.

    Superseded is what nobody decided before another proposal came for one of the same series.
    """
    decisions = {one.proposal: one for one in known.values(ProposalDecision)}
    proposals: list[Proposal] = known.values(Proposal)
    later: set[tuple[str, ...]] = set()
    found: list[tuple[Proposal, str, ProposalDecision | None]] = []
    for one in reversed(proposals):
        series = {(one.changes.value, *effect.series) for effect in one.effects}
        decision = decisions.get(one.id)
        found.append((one, decision.verdict if decision else "superseded" if series & later else "open", decision))
        later |= series
    return found[::-1]


def _view(
    one: Proposal, state: str, decision: ProposalDecision | None, book: Book | None, now: datetime
) -> ProposalView:
    offset = one.tool_offset
    return ProposalView(
        id=one.id,
        etag=state,
        changes=one.changes.value,
        part_type=one.part_type.name,
        made_at=one.made_at,
        made_by=one.made_by,
        state=state,
        effects=tuple(map(_effect, one.effects)),
        tool="" if offset is None else f"T{offset.tool}",
        dx_mm=None if offset is None else offset.x_radius_mm,
        dz_mm=None if offset is None else offset.z_mm,
        alarms=one.alarms,
        why=one.why,
        refusal=_refusal(one, book, now) if state == "open" and book is not None else "",
        decided_by="" if decision is None else decision.who,
        decided_at=None if decision is None else decision.at,
        decided_why="" if decision is None else decision.why,
    )


def _refusal(one: Proposal, book: Book, now: datetime) -> str:
    try:
        decide(one, "accepted", "", now, book.by_identity, book.decisions, SeriesOptions())
    except TrueloopError as refused:
        return f"{refused.code}: {refused.message}"
    return ""


def _effect(one: Effect) -> EffectView:
    return EffectView(
        one.characteristic,
        one.size_change_mm * UM_PER_MM,
        one.error_before_mm * UM_PER_MM,
        one.error_after_mm * UM_PER_MM,
        one.standard_u_mm * UM_PER_MM,
        one.probability_in_before,
        one.probability_in_after,
    )
