"""Figures of the estimator on NIST's metal and on a long history, as `docs/judged.md` lists them.

`python -m studies.estimator_figures` prints them; it takes some minutes. RMS in µm of what is left of E = F + C.
"""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Final
from unittest.mock import patch

import numpy as np

from scripts.nist_parts import parts
from scripts.nist_table import corrected
from studies.nist_memory import arcs, fitted, made_part, made_parts, replayed
from studies.replay.page import cut_um, inside, left_um
from studies.replay.replay import Predicted, Replayed, replay
from trueloop.estimate.catalogue import Catalogue, turned_catalogue
from trueloop.memory.edge.learnt import MemoryOptions
from trueloop.memory.edge.predict import expect
from trueloop.memory.made_part import MadePart

MODBAS2, PIECS11 = slice(1, 4), slice(5, 10)
CHOICES: Final = 40
PARTS: Final = 1000
TYPES: Final = 10


def spread_choices(count: int = CHOICES) -> list[tuple[int, ...]]:
    """Three of twenty touches, one drawn of each third."""
    rng = np.random.default_rng(1)
    return [tuple(int(rng.integers(low, high)) for low, high in ((0, 7), (7, 13), (13, 20))) for _ in range(count)]


def whole() -> tuple[Replayed, ...]:
    """The ten parts with their straight features, each from those before it; the first is not predicted."""
    return replay(made_parts(), _nothing, MemoryOptions())[1:]


def facetst() -> tuple[Replayed, ...]:
    """FACETST's parts, each from those before it; the first by the fit of its own touches."""
    family = [part for part in parts() if part.family.name == "FACETST"]
    made = [made_part(part, float(k)) for k, part in enumerate(family)]
    found = corrected(family[0]).prediction
    first = Predicted(found.before_mm - found.after_mm, found.budget.expanded_u_mm)
    return replay(made, lambda _: first, MemoryOptions())


def with_priors(factor: float) -> float:
    """The share inside of the bands of parts 4 to 10 of the worn edge, with all prior sizes so many times as large."""
    with _priors_times(factor):
        return inside(replay(made_parts(), _nothing, MemoryOptions())[3:])


def seconds(history: int) -> float:
    """Processor time of a prediction in the estimator after so many parts of ten types, sizes fitted."""
    every = [_as(part, k) for k, part in enumerate([*made_parts()] * (history // len(made_parts())))]
    today = replace(_as(made_parts()[0], history), finish=None, correction_mm=None)
    begun = time.process_time()
    expect(every, today, today.semifinish, MemoryOptions())
    first = time.process_time()
    expect(every, today, today.semifinish, MemoryOptions())
    print(
        f"after {history} parts: {first - begun:.2f} s with sizes to fit, {time.process_time() - first:.2f} s without"
    )
    return first - begun


def _as(part: MadePart, order: int) -> MadePart:
    return replace(part, order=float(order), serial=str(order), part_type=f"type {order % TYPES}")


def _nothing(part: MadePart) -> Predicted:
    return Predicted(part.semifinish.error_mm, np.full(len(part.semifinish), np.inf))


@contextmanager
def _priors_times(factor: float) -> Iterator[None]:
    """Lengths stay as they are: over these a function is smooth, whatever its size."""

    def scaled(*of: float, several_edges: bool) -> Catalogue:
        known = turned_catalogue(*of, several_edges=several_edges)
        kept = {name for name in known.priors if name.endswith("length") or name == "gain"}
        sizes = {n: p if n in kept else replace(p, median=factor * p.median) for n, p in known.priors.items()}
        return replace(known, priors=sizes)

    with patch("trueloop.memory.edge.learnt.turned_catalogue", scaled):
        yield


def _both(found: Sequence[Replayed]) -> str:
    return f"{left_um(found[MODBAS2]):.2f} / {left_um(found[PIECS11]):.2f}"


def main() -> None:
    """Prints all figures."""
    fits = [Replayed(part, 20, fitted(part.serial), True) for part in arcs()]
    print(f"arcs, all touches: {_both(replayed())}; inside {100 * inside(replayed()[1:]):.1f} %")
    choices = [replayed(one) for one in spread_choices()]
    medians = [np.median([left_um(one[of]) for one in choices]) for of in (MODBAS2, PIECS11)]
    print(f"arcs, three spread touches, median of {CHOICES}: {medians[0]:.2f} / {medians[1]:.2f}")
    print(f"each of ten as the first of its edge: {left_um(fits):.2f}; the real first {left_um(fits[:1]):.2f}")
    every = whole()
    print(
        f"whole parts: {left_um(every[:3]):.2f} / {left_um(every[4:]):.2f}, inside {100 * inside(every):.1f} %; as cut"
    )
    print(f"  {cut_um(every[:3]):.2f} / {cut_um(every[4:]):.2f}")
    print(f"FACETST: {left_um(facetst()[1:]):.2f}, as cut {cut_um(facetst()[1:]):.2f}")
    for factor in (1 / 3, 1.0, 3.0):
        print(f"priors times {factor:.2f}: inside {100 * with_priors(factor):.1f} % after three parts")
    for history in (50, PARTS):
        seconds(history)


if __name__ == "__main__":
    main()
