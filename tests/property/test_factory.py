"""Whatever is lost, told twice, told late or broken off: no cut is made twice, and none with another program.

A shop in memory: decisions alone, without a database. A cell runs each key at most once and tells its facts over a
network that keeps them back, repeats them and mixes their order; a person looks at the part before deciding. What the
machine did to the metal is counted beside it.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta
from functools import partial
from hashlib import sha256
from itertools import permutations
from random import Random

import pytest

from tests.support.factory import AT, BLOCKS, CELL, ENGINEER, OPERATOR, PLAN, SERVICE, TEXTS, touches_of
from trueloop.domain.factory import BlockKind, Conditions, FactKind, PartState, Run, RunFact, StepState
from trueloop.errors import TrueloopError
from trueloop.factory import requests as ask
from trueloop.factory.decisions import plan, runs
from trueloop.factory.decisions.plan import Candidate, CorrectionFacts, MachineFacts
from trueloop.factory.known import Changes, Offer, OrderNow

WALKS, STEPS = 200, 150
MACHINE = MachineFacts("lathe")
PROGRAMS = {sha256(text).hexdigest(): text for text in TEXTS.values()}


class Shop:
    """`cuts` counts what was done to the metal by part and step, `ran` the programs by part and step."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        facts = plan.PlanFacts(None, None, frozenset(), frozenset(PROGRAMS), 1)
        asked = replace(PLAN, conditions=Conditions(None, None, None))
        (self.order,) = plan.plan_order(facts, asked, ENGINEER, AT).orders
        self.programs = dict(PROGRAMS)
        self.runs: dict[str, Run] = {}
        self.facts: dict[str, list[RunFact]] = {}
        self.touches: dict[str, set[str]] = {}
        self.corrections: dict[str, CorrectionFacts] = {}
        self.offered: Offer | None = None
        self.started = False
        self.keys: set[str] = set()
        self.untold: list[RunFact] = []
        self.acknowledged: list[RunFact] = []
        self.cuts: dict[tuple[int, int], int] = {}
        self.ran: dict[tuple[int, int], str] = {}
        self.now = AT
        self.decided = 0
        self.moved = False

    def commit(self, changes: Changes) -> None:
        for order in changes.orders:
            self.order = order
        for one in changes.keep:
            if isinstance(one, Run):
                assert one.key not in self.runs, "a key given twice"
                self.runs[one.key] = one
            elif isinstance(one, RunFact):
                self.facts.setdefault(one.run, []).append(one)

    def known(self) -> runs.RunsFacts:
        rows = {part.value: part.row for part in self.order.parts}
        told = {
            key: runs.KnownRun(
                run, rows[run.part], tuple(self.facts.get(key, ())), frozenset(self.touches.get(key, ()))
            )
            for key, run in self.runs.items()
        }
        return runs.RunsFacts(told, {self.order.order.id: self.order})

    def tell(self, kind: FactKind) -> None:
        assert self.offered is not None
        self.now += timedelta(seconds=1)
        values = {"read_back_sha256": self.offered.run.sent_sha256} if kind is FactKind.VERIFIED else {}
        self.untold.append(RunFact(self.offered.run.key, kind, self.now, "cell", values))

    def row(self) -> int:
        assert self.offered is not None
        run = self.offered.run
        return next(one.row for one in self.order.parts if one.value == run.part)

    def ask_for_the_next_block(self, lost: bool, broken: bool) -> None:
        """The answer may be lost; the service may be ended before it commits, and then nothing of it is there."""
        chosen = plan.candidate([self.order])
        what = None
        if chosen is not None:
            order, part = chosen
            step = part.next
            assert step is not None
            made = next((one.run for one in part.steps if one.kind is BlockKind.CORRECT), "")
            text = self.programs.get(step.program_sha256)
            what = Candidate(order, part, step, text, self.corrections.get(made))
        run = None if what is None else self.runs.get(what.step.run)
        changes = plan.next_block(plan.NextFacts(MACHINE, what, run), ask.NextBlock("lathe"), CELL, self.now)
        if broken:
            return
        self.commit(changes)
        given: Offer | None = changes.answer
        if given is None or lost or given.run.key in self.keys:
            return
        assert what is not None
        assert what.part.state is not PartState.HELD
        self.offered = given
        self.keys.add(given.run.key)
        self.tell(FactKind.SENT)
        self.tell(FactKind.VERIFIED)

    def press_cycle_start(self, moves: bool) -> None:
        """`moves`: the tool has cut before whatever comes next."""
        assert self.offered is not None
        self.tell(FactKind.STARTED)
        self.started = True
        self.moved = moves
        if moves:
            self._cut()

    def the_program_ends(self) -> None:
        assert self.offered is not None
        if not self.moved:
            self._cut()
        self.tell(FactKind.ENDED)
        if self.offered.block.kind is BlockKind.PROBE:
            self.touches.setdefault(self.offered.run.key, set())
            touched = ask.RecordTouches(self.offered.run.key, "t.csv", touches_of(self.offered))
            self.commit(runs.record_touches(self.known(), touched, CELL, self.now))
            self.touches[self.offered.run.key] = {"one"}
        self.offered, self.started = None, False

    def the_power_is_cut(self) -> None:
        """The cell comes back and knows from its journal alone whether the run had started."""
        self.tell(FactKind.UNKNOWN if self.started else FactKind.FAILED)
        self.offered, self.started = None, False

    def the_network_tells(self, again: bool, lost: bool) -> None:
        some = [self.random.choice(self.untold) for _ in range(self.random.randint(1, 3))]
        changes = runs.record_facts(self.known(), ask.RecordFacts(tuple(some)), CELL, self.now)
        if lost:
            return
        self.commit(changes)
        self.acknowledged += some
        if not again:
            self.untold = [one for one in self.untold if one not in some]

    def a_person_holds(self) -> None:
        part = self.random.choice(self.order.parts)
        self._try(lambda: runs.hold(self.order, ask.Hold(self.order.order.id, part.row, "look"), OPERATOR, self.now))

    def a_person_decides(self, reject: bool) -> None:
        """Who looks at the part sees whether it was cut, once the machine stands."""
        part = next(one for one in self.order.parts if one.state is PartState.HELD)
        step = part.next
        assert step is not None
        cut = self.cuts.get((part.row, step.no), 0)
        verdict: ask.Verdict = "reject" if reject else "made" if cut else "not-made"
        request = ask.DecideStep(self.order.order.id, part.row, step.no, verdict, "looked at it")
        self.decided += 1
        self._try(lambda: runs.decide_step(self.order, request, OPERATOR, self.now))

    def a_worker_corrects(self) -> None:
        for part in self.order.parts:
            step = part.next
            if step is None or step.kind is not BlockKind.CORRECT or part.state is PartState.HELD:
                continue
            probe = next(one.run for one in part.steps if one.kind is BlockKind.PROBE)
            name = f"c{part.row}"
            text = TEXTS["finish"] + name.encode()
            sha = sha256(text).hexdigest()
            self.programs[sha] = text
            source = BLOCKS[3].program_sha256
            self.corrections[name] = CorrectionFacts(name, (part.value.identity,), source, sha, probe)
            request = ask.StepCorrected(self.order.order.id, part.row, step.no, probe, name, sha, "")
            self._try(partial(runs.step_corrected, self.order, request, SERVICE, self.now))

    def a_person_takes_parts_out(self) -> None:
        for part in self.order.parts:
            if part.next is not None and part.next.kind in (BlockKind.REMOVE, BlockKind.RELEASE):
                request = ask.RecordStep(self.order.order.id, part.row, part.next.no, "done")
                self._try(partial(runs.record_step, self.order, request, ENGINEER, self.now))

    def the_clock_jumps(self) -> None:
        self.now += timedelta(seconds=self.random.randint(-3600, 3600))

    def step(self) -> None:
        """One thing happens, of those that can; what shops do most comes most."""
        r = self.random.random
        held = any(one.state is PartState.HELD for one in self.order.parts)
        ways: list[tuple[float, bool, Callable[[], None]]] = [
            (4.0, self.offered is None, lambda: self.ask_for_the_next_block(r() < 0.15, r() < 0.1)),
            (4.0, self.offered is not None and not self.started, lambda: self.press_cycle_start(r() < 0.5)),
            (4.0, self.started, self.the_program_ends),
            (0.4, self.offered is not None, self.the_power_is_cut),
            (6.0, bool(self.untold), lambda: self.the_network_tells(r() < 0.3, r() < 0.2)),
            (0.1, True, self.a_person_holds),
            (2.0, held and not self.started, lambda: self.a_person_decides(r() < 0.03)),
            (1.0, True, self.a_worker_corrects),
            (0.5, True, self.a_person_takes_parts_out),
            (0.1, True, self.the_clock_jumps),
        ]
        can = [(weight, way) for weight, may, way in ways if may]
        (way,) = self.random.choices([way for _, way in can], [weight for weight, _ in can])
        way()
        self.no_cut_is_made_twice()
        self.steps_are_made_in_their_order()
        self.a_finish_cut_ran_what_was_accepted()
        self.no_acknowledged_fact_is_lost()
        self.at_most_one_part_is_in_the_machine()

    def no_cut_is_made_twice(self) -> None:
        assert all(count == 1 for count in self.cuts.values()), self.cuts

    def steps_are_made_in_their_order(self) -> None:
        for part in self.order.parts:
            done = [one.state is StepState.RECORDED for one in part.steps]
            assert done == sorted(done, reverse=True)

    def a_finish_cut_ran_what_was_accepted(self) -> None:
        for (row, step), sha in self.ran.items():
            if BLOCKS[step].kind is BlockKind.FINISH:
                assert sha == sha256(TEXTS["finish"] + f"c{row}".encode()).hexdigest()

    def no_acknowledged_fact_is_lost(self) -> None:
        kept = {one.identity for told in self.facts.values() for one in told}
        assert {one.identity for one in self.acknowledged} <= kept
        assert len(kept) == sum(map(len, self.facts.values())), "a fact kept twice"

    def at_most_one_part_is_in_the_machine(self) -> None:
        assert sum(one.on_machine for one in self.order.parts) <= 1

    def _cut(self) -> None:
        assert self.offered is not None
        if self.offered.block.kind.cuts:
            place = (self.row(), self.offered.run.step)
            self.cuts[place] = self.cuts.get(place, 0) + 1
            self.ran[place] = sha256(self.offered.program).hexdigest()

    def _try(self, decide: Callable[[], Changes]) -> None:
        try:
            self.commit(decide())
        except TrueloopError as refused:
            assert refused.code.startswith("FAC")


@pytest.mark.parametrize("first", range(0, WALKS, 50))
def test_no_walk_cuts_twice_or_by_another_program(first: int) -> None:
    """Every walk is repeatable by its number; together they come to where it matters."""
    came: Counter[str] = Counter()
    for seed in range(first, first + 50):
        shop = Shop(seed)
        for _ in range(STEPS):
            shop.step()
        kinds = [fact.what for told in shop.facts.values() for fact in told]
        came["finish cuts"] += sum(BLOCKS[step].kind is BlockKind.FINISH for _, step in shop.ran)
        came["unknown"] += kinds.count(FactKind.UNKNOWN)
        came["second attempts"] += sum(run.attempt > 1 for run in shop.runs.values())
        came["decided"] += shop.decided
    assert min(came[one] for one in ("finish cuts", "unknown", "second attempts", "decided")) >= 20, came


def test_the_order_of_facts_does_not_matter() -> None:
    """Of every order in which the facts of a run can arrive, the step comes to the same."""
    machine = Shop(0)
    machine.ask_for_the_next_block(False, False)
    machine.press_cycle_start(True)
    machine.the_program_ends()
    told = list(machine.untold)
    assert [one.what for one in told] == [FactKind.SENT, FactKind.VERIFIED, FactKind.STARTED, FactKind.ENDED]
    came: set[tuple[PartState, StepState]] = set()
    for order in permutations(told):
        again: OrderNow = machine.order
        machine.facts = {}
        for one in order:
            machine.commit(runs.record_facts(machine.known(), ask.RecordFacts((one,)), CELL, machine.now))
        part = machine.order.parts[0]
        came.add((part.state, part.steps[0].state))
        machine.order = again
    assert came == {(PartState.SEMIFINISHED, StepState.RECORDED)}
