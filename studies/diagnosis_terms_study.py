"""Which axis error: the judge of `trueloop.diagnosis.terms` and the report's own way, on simulated parts."""

from collections import Counter
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from studies.diagnosed.part_types import TYPES
from studies.diagnosed.seen import MachineSeen, machine_seen, together
from studies.diagnosed.shop import Shop, cut_series
from studies.diagnosed.truth import Truth
from studies.diagnosis_cases import AXES, TERMS, wrong_axis
from studies.diagnosis_shares import share, table
from trueloop.arrays import Array
from trueloop.diagnosis.terms.judge import Verdict, judge, one_after_another
from trueloop.diagnosis.terms.suspects import Residuals
from trueloop.errors import TrueloopError
from trueloop.machine.model.model import State
from trueloop.machine.model.term import chain_of

CHAIN: Final = chain_of("turning")
SIZE_MM: Final = 0.005
BATCH: Final = 5


@dataclass(frozen=True)
class Measured:
    """How the parts were made: tools by batches of five parts, types in turn, whether the machine warms."""

    parts: int = 20
    tools: tuple[str, ...] = ("T1", "T2", "T3")
    steady: bool = False
    types: int = len(TYPES)


@dataclass(frozen=True)
class Answer:
    """Of one trial: the truth ("" nothing), names in the sets, and what the report's way names."""

    truth: str
    sets: tuple[tuple[str, ...], ...]
    report: str

    @property
    def held(self) -> bool:
        """The right error is in a set, and no other set is there; without one no set."""
        return self.truth in self.sets[0] if self.truth and len(self.sets) == 1 else not self.sets and not self.truth

    @property
    def alone(self) -> bool:
        """The right error alone."""
        return self.sets == ((self.truth,),)

    @property
    def wrong_name(self) -> bool:
        """A single name is given that is not wrong."""
        return any(len(one) == 1 and one[0] != self.truth for one in self.sets)


def residuals(seen: MachineSeen) -> Residuals:
    """As the judge takes them."""
    state = State(seen.positions, 0.0, dict(seen.signals), seen.tool_mm)
    return Residuals(seen.part, seen.normal, state, seen.residual_mm, AXES)


def measured(truth: Truth, how: Measured, seed: int) -> MachineSeen:
    """Batches of parts, each of one type with one tool, on days of their own."""
    begins = range(0, how.parts, BATCH)
    batches = []
    for k, begin in enumerate(begins):
        count = min(BATCH, how.parts - begin)
        tool = how.tools[k % len(how.tools)]
        shop = Shop(TYPES[k % how.types], (tool,), count, set_anew=(), steady=how.steady)
        batches.append(machine_seen(cut_series(truth, shop, 1000 * seed + k)))
    return together(batches)


def trial(term: str, how: Measured, seed: int) -> Answer:
    """One wrong error of 5 µm, or none."""
    rng = np.random.default_rng([seed, 22])
    truth = Truth((wrong_axis(term, rng, SIZE_MM),)) if term else Truth()
    seen = measured(truth, how, seed)
    given = residuals(seen)
    first = next(iter(one_after_another(CHAIN, given)), None)
    return Answer(term, names(judge(CHAIN, given)), "" if first is None else first.error)


def names(verdict: Verdict) -> tuple[tuple[str, ...], ...]:
    """Names of each set."""
    return tuple(one.names for one in verdict.sets)


WAYS: Final = {
    "three tools, 20 parts": Measured(),
    "one tool, 20 parts": Measured(tools=("T1",)),
    "one tool, one type, 10 parts": Measured(10, ("T1",), types=1),
    "three tools, equal temperatures": Measured(steady=True),
}


def terms(trials: int) -> str:
    """One wrong error: in a set, alone, a wrong single name; the report's way."""
    rows = []
    for name, how in WAYS.items():
        found = [trial(TERMS[k % len(TERMS)], how, k) for k in range(trials)]
        sizes = [len(one.sets[0]) for one in found if one.sets]
        rows.append([
            name, share([one.held for one in found]), share([one.alone for one in found]),
            share([one.wrong_name for one in found]), f"{np.mean(sizes) if sizes else 0:.1f}",
            share([one.report == one.truth for one in found]),
        ])  # fmt: skip
    head = ["measured", "right one in the set", "right one alone", "a single wrong name", "names a set", "report's way"]
    return table(head, rows)


def sound(trials: int) -> str:
    """Nothing wrong: nothing found, and how often the report's way finds something."""
    rows = []
    for name, how in WAYS.items():
        found = [trial("", how, 5000 + k) for k in range(trials)]
        rows.append([name, share([one.held for one in found]), share([not one.report for one in found])])
    return table(["measured", "nothing found", "report's way"], rows)


def bad_inputs(trials: int) -> str:
    """What cannot be answered is refused by name; what can only be narrowed down comes with what is missing."""
    rows = []
    for name in ("one part", "temperatures missing", "fewer points than unknowns", "equal temperatures", "one tool"):
        counted = Counter(_bad(name, TERMS[k % len(TERMS)], k) for k in range(trials))
        rows.append([name, "; ".join(f"{what} ({count})" for what, count in counted.most_common(6))])
    return table(["input", "answers (how often)"], rows)


def _bad(name: str, term: str, seed: int) -> str:
    rng = np.random.default_rng([seed, 23])
    truth = Truth((wrong_axis(term, rng, SIZE_MM),))
    how = {"equal temperatures": Measured(steady=True), "one tool": Measured(tools=("T1",))}.get(name, Measured())
    seen = measured(truth, how, seed)
    given = residuals(seen)
    if name == "one part":
        given = _rows(given, given.part == 0)
    elif name == "temperatures missing":
        given = replace(given, state=replace(given.state, signals={}))
    elif name == "fewer points than unknowns":
        given = _rows(given, np.arange(len(given.part)) % 22 == 0)
    try:
        verdict = judge(CHAIN, given)
    except TrueloopError as refused:
        return f"refused, {refused.code}"
    wrong = any(len(one) == 1 and one[0] != term for one in names(verdict))
    held = any(term in one for one in names(verdict))
    return (
        "wrong name alone"
        if wrong
        else "in the set"
        if held
        else "no finding"
        if not verdict.sets
        else "set without it"
    )


def _rows(given: Residuals, kept: Array) -> Residuals:
    state = replace(
        given.state,
        positions=given.state.positions[kept],
        signals={name: np.asarray(values)[kept] for name, values in given.state.signals.items()},
        tool_mm=np.asarray(given.state.tool_mm)[kept],
    )
    return Residuals(given.part[kept], given.normal[kept], state, given.residual_mm[kept], given.element)
