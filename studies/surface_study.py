"""How well deviations of a surface are taken apart and corrected, on simulated truths: writes docs/surface-study.md.

`python -m studies.surface_study` prints the page (some minutes), `--write` writes it; `--runs 5` is a quick look.
"""

import argparse
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from studies.surface_experiment import LEFT_BY_15, PARTS, THREE_SIGMA, WAYS, Outcome, Reading, experiment
from studies.surface_truths import GRID, NEAR, NOISE_MM, SQUARE, TRUTHS, heavy, spline, white
from trueloop.arrays import Array
from trueloop.errors import TrueloopError
from trueloop.surface.pattern.pattern import pattern_of
from trueloop.surface.separation.separate import Separation, of_size, separate
from trueloop.surface.separation.spline_surface import Size
from trueloop.units import UM_PER_MM
from trueloop_lab.simulator.machine import EXTREME_OF_625, published_process

PAGE: Final = Path(__file__).parents[1] / "docs" / "surface-study.md"
FIRST_SEED: Final = 400_000
"""No choice in the code was made with these seeds or any above them."""
CRITERIA: Final = ("likelihood", "randomness")
FEWER: Final = 0.4
HALF_OF_TEN: Final = 1.54
"""Standard deviations in half the range of ten normal values, in the mean."""
AS_THREE: Final = "edges and middle, 3 standard deviations"
AS_WRITTEN: Final = "extremes, half the range of ten; random part of 15 × 15"
READINGS: Final = {
    AS_THREE: THREE_SIGMA,
    "edges and middle, 1.96 (95 % of parts)": Reading(1.96),
    "edges and middle, half the range of ten": Reading(HALF_OF_TEN),
    "extremes, half the range of ten": Reading(HALF_OF_TEN, of_extremes=True),
    AS_WRITTEN: Reading(HALF_OF_TEN, of_extremes=True, noise_mm=THREE_SIGMA.noise_mm / LEFT_BY_15),
}
WITHIN_UM: Final = 8.0

HEAD: Final = """# What the machining pattern model gives, on simulated truths

[surface.md](surface.md) explains the method. Here it is tried where the truth is known, by simulation, on seeds that no
choice in the code was made with: the published experiment {runs} times, all else {fewer} times; 25 × 25 points over
50 × 50 mm, noise of {noise:.1f} µm at a point. `python -m studies.surface_study --write` makes this page.
"""


def page(runs: int) -> str:
    """The whole page."""
    fewer = max(2, int(FEWER * runs))
    head = HEAD.format(runs=runs, fewer=fewer, noise=NOISE_MM * 1e3)
    return "\n".join(
        [head, _published(runs, fewer), *(told(fewer) for told in (_sizes, _criteria, _coverage, _how_many))]
    )


def _published(runs: int, fewer: int) -> str:
    read = {
        name: [experiment(FIRST_SEED + k, reading) for k in range(runs if name in (AS_THREE, AS_WRITTEN) else fewer)]
        for name, reading in READINGS.items()
    }
    first, written = read[AS_THREE], read[AS_WRITTEN]
    ways = {
        "true": "the true pattern",
        "pattern": "pattern of ten parts",
        "model": "model of one part",
        "raw": "raw data",
    }
    rows = [(ways[way], *_of_way(first, way), *_of_way(written, way)[:2]) for way in WAYS]
    worst = ("worst deviation, median (µm)", f"within ±{WITHIN_UM:.0f} µm")
    return f"""
## The published experiment

Ten parts; then a new part each, cut after correction by their pattern, by the deterministic model of one part, by that
part's raw data; and, as nobody but a simulator can, by the true pattern: nothing can be better.

{table(("corrected by", *worst, "random part (µm)", *(f"as written: {head}" for head in worst)), rows)}
How often one is better than the other, for a new part each (as published) and for the very same new part:

{table(("worst deviation", "a new part each", "the same part"), _orders(first))}
Where the order fails for a new part each, the model is before the pattern in {_failing(first)} cases: one part's
model differs from the pattern by no more than parts differ, and the worst of 625 places is a matter of chance.

Raw data scatter √2 times as much as the others, not twice: the new cut leaves its random part ε₂ with variance σ², and
the correction takes away ε₁ of the part measured before. The two are independent, so the variances add up: 2 σ².
Twice would take ε₁ = −ε₂. A model takes away no more than the fit's share of ε₁, σ² times control points over places.

**What the published limits mean.** §8 gives three figures. The worst place of the one surface cut after correction by
the pattern stayed within ±8 µm. The random effects separated on ten surfaces lay, on average, within −6.4 … +6.6 µm.
Between parts the deterministic component varied by "min. ±0.0043; max. ±0.0024 mm".

- −6.4 … +6.6 µm are extremes: of residuals the paper determines "the maximum value, the minimum value", and averages
  them over ten surfaces. The largest of 625 normal values is {EXTREME_OF_625:.2f} standard deviations, so the residuals
  scatter by {_noise(AS_THREE)} µm. They are what a model of 15 × 15 control points left; if it was one of least
  squares, the touches scattered by 1/{LEFT_BY_15:.1f} of that, {_noise(AS_WRITTEN)} µm.
- "min." and "max." cannot be the least and the greatest of the variability over the surface: "min." is the larger. Like
  the two limits of the random effects in the sentence before they are those of the smallest and of the largest
  deviation, and ± is half the range of ten parts: {HALF_OF_TEN} standard deviations.

Both together are called *as written*. The milder reading above, on which all else here rests, takes three standard
deviations, ±2.4 µm in the middle of the surface and ±4.3 µm at its edges:

{table(_READ, _readings(read))}
True pattern, pattern, model: share of parts within ±{WITHIN_UM:.0f} µm. Coverage: share of places where the true
pattern lies within the 95 % uncertainty. Min., max.: half the range, in µm, over which the smallest and the largest
value of the ten deterministic models vary, median of experiments; published 4.3 and 2.4.

So within ±{WITHIN_UM:.0f} µm, as the published sample, stay {_within(first, "pattern")} of parts by the milder reading
and {_within(written, "pattern")} as written; corrected by the true pattern {_within(first, "true")} and
{_within(written, "true")}. No correction can do better than that: ±{WITHIN_UM:.0f} µm is one sample, and a lucky one,
or the limits mean less than they say.
"""


def _of_way(outcomes: Sequence[Outcome], way: str) -> tuple[str, ...]:
    worst = [o.worst_um[way] for o in outcomes]
    random = np.mean([o.random_um[way] for o in outcomes])
    return f"{np.median(worst):.1f}", _share(w <= WITHIN_UM for w in worst), f"{random:.2f}"


def _orders(outcomes: Sequence[Outcome]) -> Iterable[tuple[str, ...]]:
    for better, worse in (("pattern", "model"), ("model", "raw"), ("pattern", "raw")):
        each = _share(o.worst_um[better] < o.worst_um[worse] for o in outcomes)
        yield f"{better} before {worse}", each, _share(o.same_um[better] < o.same_um[worse] for o in outcomes)
    yield "pattern, model, raw in this order", _share(map(_ordered, outcomes)), _share(map(_ordered_same, outcomes))


_READ: Final = (
    "± read as",
    "order",
    "order, same part",
    *("true pattern", "pattern", "model"),
    "coverage",
    "min.",
    "max.",
)


def _readings(read: dict[str, list[Outcome]]) -> Iterable[tuple[str, ...]]:
    for name, outcomes in read.items():
        within = (_share(o.worst_um[way] <= WITHIN_UM for o in outcomes) for way in WAYS[:3])
        coverage = 100 * np.mean([o.coverage for o in outcomes])
        varied = np.median([o.varied_um for o in outcomes], axis=0)
        order = _share(map(_ordered, outcomes)), _share(map(_ordered_same, outcomes))
        yield name, *order, *within, f"{coverage:.1f} %", *(f"±{um:.1f}" for um in varied)


def _within(outcomes: Sequence[Outcome], way: str) -> str:
    return _of_way(outcomes, way)[1]


def _noise(reading: str) -> str:
    return f"{READINGS[reading].noise_mm * UM_PER_MM:.2f}"


def _ordered(outcome: Outcome) -> bool:
    return outcome.worst_um["pattern"] < outcome.worst_um["model"] < outcome.worst_um["raw"]


def _ordered_same(outcome: Outcome) -> bool:
    return outcome.same_um["pattern"] < outcome.same_um["model"] < outcome.same_um["raw"]


def _failing(outcomes: Sequence[Outcome]) -> str:
    """How many of the failures of the order are one part's model before the pattern."""
    failed = [o for o in outcomes if not _ordered(o)]
    by_model = sum(o.worst_um["model"] <= o.worst_um["pattern"] for o in failed)
    return f"{by_model} of {len(failed)}"


def _sizes(runs: int) -> str:
    rows = [
        (f"{true} × {true}", f"{1e3 * scatter:.0f} µm", *(_found(runs, true, scatter, c, 1) for c in CRITERIA),
         _found(runs, true, scatter, "likelihood", PARTS))
        for true in (7, 9, 12, 15) for scatter in (0.004, 0.008, 0.020)
    ]  # fmt: skip
    head = ("true size", "control values", *CRITERIA, "likelihood, mean of ten parts")
    return f"""
## The number of control points

How often a known pattern's number of control points is found to one step along both sides. Control values are normal
with the standard deviation given.

{table(head, rows)}
The published tests (`randomness`) stop as soon as they see nothing more: what is missed of a weak pattern with many
control points is then near the noise of a single part. `likelihood` weighs all control points at once.
"""


def _found(runs: int, true: int, scatter_mm: float, criterion: str, parts: int) -> str:
    def near(seed: int) -> bool:
        rng = np.random.default_rng(seed)
        errors = spline(rng, true, scatter_mm) + white(rng) / np.sqrt(parts)
        try:
            size = separate(SQUARE, errors, near=NEAR, criterion=criterion).chosen.size
        except TrueloopError:  # no size leaves random residuals
            return False
        return max(abs(size.rows - true), abs(size.columns - true)) <= 1

    return _share(near(FIRST_SEED + k) for k in range(runs))


def _criteria(runs: int) -> str:
    rows = [
        (name, kind, *(_distance(runs, name, noise, criterion) for criterion in CRITERIA))
        for name in TRUTHS for kind, noise in (("normal", white), ("heavy tails", heavy))
    ]  # fmt: skip
    return f"""
## The two criteria

Distance of the deterministic part from the truth, root mean square in µm: median and largest of {runs} parts. Heavy
tails: noise of the same scatter by Student's law with four degrees of freedom. The published criterion wants residuals
to be normal and goes on adding control points when their tails are the machine's own.

{table(("truth", "noise", *CRITERIA), rows)}"""


def _distance(runs: int, name: str, noise: Callable[[np.random.Generator], Array], criterion: str) -> str:
    off = []
    for k in range(runs):
        rng = np.random.default_rng(FIRST_SEED + k)
        truth = TRUTHS[name](rng)
        try:
            found = separate(SQUARE, truth + noise(rng), near=NEAR, criterion=criterion)
        except TrueloopError:
            continue
        off.append(1e3 * np.sqrt(np.mean((found.deterministic.grid_mm(GRID, GRID).ravel() - truth) ** 2)))
    failed = f"; {runs - len(off)} refused" if len(off) < runs else ""
    return f"{np.median(off):.2f}, {np.max(off):.2f}{failed}"


def _coverage(runs: int) -> str:
    rows = []
    for name in TRUTHS:
        covered, width, rest = np.array([_covered(FIRST_SEED + k, name, PARTS) for k in range(runs)]).mean(axis=0)
        rows.append((name, f"{100 * covered:.1f} %", f"{width:.2f}", f"{rest:.2f}"))
    return f"""
## The uncertainty of the pattern

Share of places where the true pattern lies within the 95 % uncertainty of a pattern of ten parts; the mean half-width
of that uncertainty in µm, and what of it no control point follows (root mean square over the pattern).

{table(("truth", "covered", "half-width", "not followed"), rows)}"""


def _how_many(runs: int) -> str:
    rows = []
    for parts in (3, 5, 10, 20):
        covered, width, _ = np.array([_covered(FIRST_SEED + k, _KNOWN, parts) for k in range(runs)]).mean(axis=0)
        rows.append((str(parts), f"{100 * covered:.1f} %", f"{width:.2f}"))
    return f"""
## How many parts

The same for the {_KNOWN}, and more or fewer parts:

{table(("parts", "covered", "half-width"), rows)}"""


_KNOWN: Final = "spline of 9 × 9, 8 µm"


def _covered(seed: int, name: str, count: int) -> tuple[float, float, float]:
    rng = np.random.default_rng(seed)
    process, truth = published_process(rng), TRUTHS[name](rng)
    parts = [_part(truth + process.variation(rng).grid_mm(GRID, GRID).ravel() + white(rng)) for _ in range(count)]
    pattern = pattern_of(parts, [f"S{k + 1}" for k in range(count)])
    half = pattern.uncertainty_grid_mm(GRID, GRID).ravel()
    off = np.abs(pattern.mean.grid_mm(GRID, GRID).ravel() - truth)
    return float(np.mean(off <= half)), 1e3 * float(np.mean(half)), 1e3 * pattern.missed_mm


def _part(errors_mm: Array) -> Separation:
    """A part whose own size does not matter: the mean of all parts says which size the pattern has."""
    return of_size(SQUARE, errors_mm, Size(4, 4), NEAR)


def _share(those: Iterable[bool]) -> str:
    return f"{100 * np.mean(list(those)):.0f} %"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A Markdown table: first column text, the others numbers."""
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def main() -> None:
    """Prints or writes the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--runs", type=int, default=100)
    given = parser.parse_args()
    text = page(given.runs)
    if given.write:
        PAGE.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
