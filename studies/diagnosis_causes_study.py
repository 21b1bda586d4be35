"""Which cause: the judge of `trueloop.diagnosis.causes` on simulated series whose truth was written down before."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from studies.diagnosed.seen import points_of, seen_series
from studies.diagnosed.shop import Series, cut_series
from studies.diagnosed.truth import Fault
from studies.diagnosis_cases import LETTERS, OTHERS, SEEN_BY_FEATURES, Case, machine_case, pairs, process_case
from studies.diagnosis_shares import share, table
from trueloop.arrays import Array
from trueloop.diagnosis.causes.cause import Diagnosis, SeenSeries
from trueloop.diagnosis.causes.judge import judge
from trueloop.diagnosis.features.errors_of import errors_of
from trueloop.diagnosis.features.feature_error import FeatureError
from trueloop.errors import TrueloopError

KEYS: Final = {
    Fault.TOOL_OFFSET: "tool-setting",
    Fault.WEAR: "tool-wear",
    Fault.PROBE_OFFSET: "part-probe-offset",
    Fault.PROBE_LAG: "part-probe-offset",
    Fault.UNEQUAL_DEPTH: "unequal-depth",
    Fault.TWO_TOOLS: "two-tools",
    Fault.PART_DEFLECTION: "part-deflection",
    Fault.FACE_DEFLECTION: "tool-deflection",
    Fault.CONSTANT_SPEED: "constant-speed",
    Fault.CHATTER: "chatter",
    Fault.TOOL_SEAT: "tool-seat",
    Fault.TOOL_SLIP: "tool-seat",
    Fault.PROBE_LOOSE: "fixturing-part-probe",
    Fault.RUN_OUT: "chuck",
    Fault.JAWS: "jaws",
    Fault.AXIS_ERROR: "machine",
}
"""What each fault of the shop is called in the catalogue."""
FOUND: Final = 0.5
"""From this probability on a cause is a finding."""
SURE: Final = 0.95
"""A cause this probable that does not act counts as a wrong name."""


@dataclass(frozen=True)
class Answer:
    """Of one series: the truth by the catalogue's keys, causes with their probabilities, likeliest first."""

    truth: frozenset[str]
    ordered: tuple[tuple[str, float], ...]
    refused: str = ""

    @property
    def first(self) -> bool:
        """The causes that act are the first ones, each a finding."""
        head = self.ordered[: len(self.truth)]
        return {key for key, _ in head} == self.truth and all(chance >= FOUND for _, chance in head)

    @property
    def exact(self) -> bool:
        """Every cause that acts is found, and no other."""
        return self.truth <= self.found <= self.truth | self.allowed

    @property
    def found(self) -> frozenset[str]:
        """Causes that are findings."""
        return frozenset(key for key, chance in self.ordered if chance >= FOUND)

    @property
    def allowed(self) -> frozenset[str]:
        """What is as true: an edge that wears does so between two passes of one part too."""
        return frozenset({"wear-between"} if "tool-wear" in self.truth else ())

    @property
    def wrong_name(self) -> bool:
        """The answer is sure of a cause that does not act."""
        return any(chance >= SURE and key not in self.truth | self.allowed for key, chance in self.ordered)


def answer(case: Case) -> Answer:
    """Cut the series, look at it without the truth, and compare."""
    truth = frozenset(KEYS[one.fault] for one in case.truth.wrong)
    try:
        return _of(truth, judge(seen(cut_series(case.truth, case.shop, case.seed))))
    except TrueloopError as refused:
        return Answer(truth, (), str(refused.code))


def seen(series: Series) -> SeenSeries:
    """What the judge gets, feature errors by `errors_of`."""

    def errors(of: Series, error_mm: Array, standard_u_mm: float) -> tuple[FeatureError, ...]:
        return errors_of(points_of(of, error_mm, standard_u_mm), of.places)

    return seen_series(series, errors)


def _of(truth: frozenset[str], found: Diagnosis) -> Answer:
    chances: dict[str, float] = {}
    for keys, chance in found.hypotheses:
        for key in keys:
            chances[key] = chances.get(key, 0.0) + chance
    ordered = sorted(chances.items(), key=lambda item: -item[1])
    return Answer(truth, tuple(ordered))


def single(trials: int) -> str:
    """One cause of the process, by feature error and by cause; `trials` of each cause."""
    rows = []
    for letter, faults in LETTERS.items():
        found = {
            fault: _answers([process_case((fault,), 100 * k + n) for k in range(trials)])
            for n, fault in enumerate(faults)
        }
        rows.append(_row(f"**{letter}**", [one for answers in found.values() for one in answers]))
        rows += [_row(str(fault), answers) for fault, answers in found.items()]
    return table(HEAD, rows)


def others(trials: int) -> str:
    """Fixtures, chuck and jaws; and the machine's model, each error that features show in turn."""
    rows = [_row(str(fault), _answers([process_case((fault,), 7000 + k) for k in range(trials)])) for fault in OTHERS]
    machine = _answers([machine_case(SEEN_BY_FEATURES[k % len(SEEN_BY_FEATURES)], 8000 + k) for k in range(2 * trials)])
    return table(HEAD, [*rows, _row("one wrong axis error", machine)])


def two(trials: int) -> str:
    """Two causes at once on different feature errors."""
    drawn = list(pairs())
    found = _answers([process_case(drawn[k % len(drawn)], 20_000 + k) for k in range(8 * trials)])
    return table(HEAD, [_row(f"{len(drawn)} pairs in turn", found)])


def sound(trials: int) -> str:
    """Nothing acts: no cause is a finding."""
    found = _answers([process_case((), 30_000 + k) for k in range(8 * trials)])
    quiet = share([not one.refused and not one.found for one in found])
    return table(["series", "no finding", "found instead"], [["sound", quiet, _instead(found)]])


def gains(trials: int) -> str:
    """A correction that arrives not at all or twice: what the judge answers."""
    rows = []
    for gain in (0.0, 1.0, 2.0):
        counted: Counter[str] = Counter()
        for k in range(trials):
            case = process_case((Fault.TOOL_OFFSET,), 40_000 + k)
            shop = replace(case.shop, corrected_from=case.shop.parts // 2, set_anew=())
            counted[_gain_answer(Case(replace(case.truth, gain=gain), shop, case.seed))] += 1
        rows.append([f"gain {gain:g}", "; ".join(f"{what} ({count})" for what, count in counted.most_common(4))])
    return table(["correction", "answers (how often)"], rows)


def _gain_answer(case: Case) -> str:
    found = answer(case)
    if found.refused:
        return f"refused, {found.refused}"
    return " + ".join(sorted(found.found)) or "nothing"


HEAD: Final = ("wrong", "named first", "found and no other", "sure of a wrong name", "found instead")


def _answers(cases: Sequence[Case]) -> list[Answer]:
    return [answer(case) for case in cases]


def _row(name: str, found: Sequence[Answer]) -> list[str]:
    return [
        name, str(share([one.first for one in found])), str(share([one.exact for one in found])),
        str(share([one.wrong_name for one in found])), _instead(found),
    ]  # fmt: skip


def _instead(found: Sequence[Answer]) -> str:
    counted = Counter(_words(one) for one in found if not one.exact)
    return "; ".join(f"{what} ({count})" for what, count in counted.most_common(3))


def _words(one: Answer) -> str:
    return one.refused or " + ".join(sorted(one.found)) or "nothing"
