"""What is wrong in the series of the diagnosis study, and in which shop: drawn once, before a part is cut."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from studies.diagnosed.part_types import DISC, SLIM, STUB, TYPES, PartType
from studies.diagnosed.shop import Shop
from studies.diagnosed.truth import Fault, Truth, Wrong

LETTERS: Final[Mapping[str, tuple[Fault, ...]]] = {
    "a radius": (Fault.TOOL_OFFSET, Fault.WEAR, Fault.PROBE_OFFSET),
    "b length": (Fault.UNEQUAL_DEPTH, Fault.TWO_TOOLS),
    "c taper of a shaft": (Fault.PART_DEFLECTION,),
    "d taper of a face": (Fault.FACE_DEFLECTION, Fault.CONSTANT_SPEED),
    "f straightness": (Fault.CHATTER,),
}
"""Causes of the process by the feature errors of [4773 §4.2]; e, an edge, no touch sees."""
OTHERS: Final = (Fault.TOOL_SEAT, Fault.TOOL_SLIP, Fault.PROBE_LOOSE, Fault.PROBE_LAG, Fault.RUN_OUT, Fault.JAWS)
ONE_SIGN: Final = frozenset(
    {Fault.WEAR, Fault.UNEQUAL_DEPTH, Fault.PART_DEFLECTION, Fault.FACE_DEFLECTION, Fault.CONSTANT_SPEED}
)
SIZE_MM: Final[Mapping[Fault, tuple[float, float]]] = {
    Fault.WEAR: (0.012, 0.040),
    Fault.PART_DEFLECTION: (0.010, 0.030),
    Fault.FACE_DEFLECTION: (0.012, 0.030),
    Fault.CONSTANT_SPEED: (0.012, 0.030),
    Fault.CHATTER: (0.003, 0.008),
    Fault.TOOL_SEAT: (0.005, 0.012),
    Fault.PROBE_LOOSE: (0.005, 0.012),
    Fault.RUN_OUT: (0.004, 0.012),
    Fault.JAWS: (0.004, 0.012),
}
USUAL_MM: Final = (0.006, 0.020)
"""Sizes are drawn between these, their logarithms evenly."""
AXES: Final[Mapping[str, str]] = {"X": "T cross slide", "Z": "T carriage", "C": "T spindle"}
TERMS: Final = ("EXX", "EZX", "EBX", "EXZ", "EZZ", "EBZ", "EX0C", "EZ0C", "EB0C")
SEEN_BY_FEATURES: Final = tuple(term for term in TERMS if term != "EZ0C")
"""A spindle that grows moves all faces alike, which is in no feature error."""
ARM_MM: Final = 80.0


@dataclass(frozen=True)
class Case:
    """A series to come: what is wrong, in which shop, by which seed."""

    truth: Truth
    shop: Shop
    seed: int


def process_case(faults: tuple[Fault, ...], seed: int) -> Case:
    """A shop in which these act. Parts, settings, tools and corrections are as shops differ."""
    rng = np.random.default_rng([seed, 20])
    parts = int(rng.integers(8, 21))
    two = Fault.TWO_TOOLS in faults or bool(rng.random() < 0.5)
    shop = Shop(
        part=_fitting(faults, rng),
        tools=("T1", "T2") if two else ("T1",),
        parts=parts,
        set_anew=() if Fault.TOOL_SLIP in faults else (int(rng.integers(parts // 3, 2 * parts // 3 + 1)),),
        corrected_from=int(rng.integers(4, parts)) if rng.random() < 0.5 else None,
        standard_at=(0, parts // 2),
    )
    return Case(Truth(tuple(_sized(fault, rng) for fault in faults)), shop, seed)


def machine_case(term: str, seed: int) -> Case:
    """Only the model is wrong: in a shop as the others, one axis error that grows with its own temperature."""
    case = process_case((), seed)
    rng = np.random.default_rng([seed, 21])
    return replace(case, truth=Truth((wrong_axis(term, rng, float(rng.uniform(0.008, 0.020))),)))


def wrong_axis(term: str, rng: np.random.Generator, size_mm: float, constant: float | None = None) -> Wrong:
    """An axis error of that size over the usual arm, 8 K above the reference, part of it there at the reference."""
    share = float(rng.uniform(0.0, 0.5)) if constant is None else constant
    size = size_mm * float(rng.choice([-1.0, 1.0])) / (ARM_MM if term[1] == "B" else 1.0)
    bend = float(rng.uniform(-0.3, 0.3))
    return Wrong(Fault.AXIS_ERROR, size, error=term, signal=AXES[term[-1]], constant=share, bend=bend)


def pairs() -> Iterator[tuple[Fault, Fault]]:
    """Two causes of the process on different feature errors, as far as both can show."""
    letters = list(LETTERS.values())
    for k, some in enumerate(letters):
        for others in letters[k + 1 :]:
            yield from ((one, other) for one in some for other in others if _both(one, other))


def _both(one: Fault, other: Fault) -> bool:
    slim, flat = {Fault.PART_DEFLECTION}, {Fault.FACE_DEFLECTION, Fault.CONSTANT_SPEED}
    return not ({one, other} & slim and {one, other} & flat)


def _fitting(faults: tuple[Fault, ...], rng: np.random.Generator) -> PartType:
    """A slim part bends, a large face shows a taper; any part shows the rest."""
    if Fault.PART_DEFLECTION in faults:
        return SLIM
    if Fault.FACE_DEFLECTION in faults or Fault.CONSTANT_SPEED in faults:
        return DISC
    return (SLIM, DISC, STUB)[int(rng.integers(len(TYPES)))]


def _sized(fault: Fault, rng: np.random.Generator) -> Wrong:
    low, high = np.log(SIZE_MM.get(fault, USUAL_MM))
    size = float(np.exp(rng.uniform(low, high)))
    sign = 1.0 if fault in ONE_SIGN or fault in SIZE_MM else float(rng.choice([-1.0, 1.0]))
    return Wrong(fault, sign * size, "T2" if fault is Fault.TWO_TOOLS else "")
