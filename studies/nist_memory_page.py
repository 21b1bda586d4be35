"""The page docs/nist-memory.md: what memory makes of NIST's ten worn-nose parts, beside simple rules.

`python -m studies.nist_memory_page` prints the page, `--write` writes it.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from studies.nist_memory import THREE, arcs, as_first, made_parts, own_fit, replayed, replayed_parts
from studies.replay.page import cut_um, inside, left_um
from studies.replay.replay import Replayed
from trueloop.arrays import Array
from trueloop.memory.made_part import MadePart
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM

PAGE: Final = Path(__file__).parents[1] / "docs" / "nist-memory.md"
MODBAS2: Final = slice(0, 4)
PIECS11: Final = slice(4, 10)
INSPECTED: Final = ("2511", "2611", "2711", "2811", "3811", "3511", "3611", "3711", "3812", "3911")
"""The parts by the number of their inspection: 3811.154 comes before 3511.158."""

HEAD: Final = """# Memory on NIST's metal

Ten parts that one worn edge cut, four MODBAS2 and six PIECS11, each touched at twenty points of its dome or knob after
the semi-finish cut and again after a finish cut that NIST had corrected (NISTIR 6811, Tables 8 to 11). NIST's
correction C is rebuilt as the report says (§3.2: a spline with a knot at every third touch) and added to the error F of
its finish cut: E = F + C is the error had nothing been corrected. E less a prediction is what the prediction would have
left in that metal, had it been the correction.

Every part is predicted from the parts before it, in the order of their numbers, and from its own touches. Figures are
root mean squares over the arc in µm. `make demo-memory` writes every point (`out/memory/replay.csv`) and a page.
"""

FOOT: Final = """
[Memory](memory.md#choices-made-after-seeing-the-figures) lists the choices made after seeing these figures. Ten
parts, one edge, one machine, arcs only: other metal will show more.

`python -m studies.nist_memory_page --write` makes this page; a test compares it with what the code gives.
"""


def simple(of: slice, start: Callable[[MadePart], Array], share: Callable[[int], float]) -> float:
    """RMS left by a rule without a model: a start from today's touches and a share of what it left on earlier parts."""
    parts, errors = arcs()[of], []
    for k, part in enumerate(parts[1:], 1):
        earlier = np.mean([_uncorrected(one) - start(one) for one in parts[:k]], axis=0)
        errors.append(_uncorrected(part) - start(part) - share(k) * earlier)
    return rms(np.concatenate(errors)) * UM_PER_MM


def page() -> str:
    """The whole page."""
    return f"{HEAD}\n{_against_rules()}\n{_other_cases()}\n{_bands()}{FOOT}"


def _against_rules() -> str:
    rules: list[tuple[str, Callable[[slice], float]]] = [
        ("as NIST cut them", lambda of: cut_um(replayed()[of][1:])),
        ("fit of the part's own touches", lambda of: left_um(_fits(of)[1:])),
        ("the same, and 0.75 of the mean that it left before", lambda of: simple(of, _fit, lambda k: 0.75)),
        ("bare touches, and k/(k + 1) of the mean left before", lambda of: simple(of, _touches, lambda k: k / (k + 1))),
        ("memory, 20 touches", lambda of: left_um(replayed()[of][1:])),
        ("memory, the 3rd, 10th and 17th touch", lambda of: left_um(replayed(THREE)[of][1:])),
    ]
    rows = [f"| {name} | {rule(MODBAS2):.2f} | {rule(PIECS11):.2f} |" for name, rule in rules]
    return f"""## Types that the edge had cut before

| | MODBAS2, parts 2 to 4 | PIECS11, parts 2 to 6 |
|---|--:|--:|
{chr(10).join(rows)}

With twenty touches memory is little better than the plainest rule that learns at all: the touches as they are, and a
share of the mean that earlier parts had left. It needs fewer touches, knows types it has not cut, and says how far it
may be off.
"""


def _other_cases() -> str:
    first, piecs11 = replayed()[0:1], replayed()[4:5]
    reordered = [by_serial(serial, k) for k, serial in enumerate(INSPECTED)]
    by_inspection, alone = (
        [replayed_parts(parts, touches) for touches in (None, THREE)] for parts in (reordered, made_parts()[PIECS11])
    )
    rows = [
        ("first part of the edge: own fit", cut_um(first), left_um(first), None),
        ("first PIECS11 part, 16° of it never seen", cut_um(piecs11), left_um(piecs11), None),
        (
            "each PIECS11 part as the first, at angles seen (17 or 18 touches)",
            cut_um(as_first()),
            left_um(as_first()),
            None,
        ),
        ("PIECS11, parts 2 to 6, MODBAS2 unknown", cut_um(alone[0][1:]), *(left_um(one[1:]) for one in alone)),
        (
            "PIECS11, parts 2 to 6, by number of inspection",
            cut_um(by_inspection[0][5:]),
            *(left_um(one[5:]) for one in by_inspection),
        ),
    ]
    lines = [
        f"| {name} | {cut:.2f} | {twenty:.2f} | {'–' if three is None else f'{three:.2f}'} |"
        for name, cut, twenty, three in rows
    ]
    return f"""## Other cases

| | as cut | memory, all touches | 3 touches |
|---|--:|--:|--:|
{chr(10).join(lines)}

Where contact angles were never seen, three touches are refused. By the numbers of their inspections 3811 was cut before
3511: the order of the parts is not beyond doubt.
"""


def _bands() -> str:
    shares = [f"{inside(replayed(touches)[1:]) * 100:.1f} %" for touches in (None, THREE)]
    return f"""## Bands

Of all points but those of the edge's first part, {shares[0]} are inside their 95 % band with twenty touches,
{shares[1]} with three. Points of one part go together, so that nine parts tell this share to some percent only.
"""


def by_serial(serial: str, order: int) -> MadePart:
    """A part at another place in the order."""
    return replace(next(part for part in made_parts() if part.serial == serial), order=float(order))


def _fits(of: slice) -> Sequence[Replayed]:
    return [Replayed(part, len(part.semifinish.error_mm), own_fit(part), True) for part in arcs()[of]]


def _fit(part: MadePart) -> Array:
    return own_fit(part).error_mm


def _touches(part: MadePart) -> Array:
    return part.semifinish.error_mm


def _uncorrected(part: MadePart) -> Array:
    uncorrected = part.uncorrected_mm
    assert uncorrected is not None
    return uncorrected


def main() -> None:
    """Prints or writes the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    if parser.parse_args().write:
        PAGE.write_text(page(), encoding="utf-8")
    else:
        print(page())


if __name__ == "__main__":
    main()
