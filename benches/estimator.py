"""A prediction by memory with a hundred and a thousand parts of ten types behind it, and its shares."""

from dataclasses import replace

import numpy as np

from benches.ratio import Contender, compare, verdict
from trueloop.estimate.sizes import _KNOWN
from trueloop.memory.edge import learnt as of_edge
from trueloop.memory.edge.learnt import MemoryOptions
from trueloop.memory.edge.predict import expect
from trueloop.memory.made_part import CutErrors, MadePart

TYPES = 10
SHORT, LONG = 100, 1000


def made(order: int) -> MadePart:
    """A part of five features with 32 touches and as many inspected points."""
    rng, n = np.random.default_rng(order), 32
    feature = np.repeat(["face", "dome", "cone", "seat", "collar"], [4, 14, 5, 5, 4]).tolist()
    angle = np.concatenate(
        [np.zeros(4), np.linspace(0.1, 1.5, 14), np.full(5, 1.3), np.full(5, np.pi / 2), np.zeros(4)]
    )
    error = 0.008 * np.sin(2 * angle) + 0.002 * rng.normal() * np.sin(angle) + 0.001 * rng.normal(size=n)
    cut = CutErrors(
        feature=tuple(feature),
        point=tuple(map(str, range(n))),
        contact_angle_rad=angle,
        error_mm=error,
        standard_u_mm=np.full(n, 5e-4),
        z_mm=np.linspace(30.0, -30.0, n),
        share=np.concatenate([np.linspace(0.1, 0.9, k) for k in (4, 14, 5, 5, 4)]),
    )
    left = replace(cut, error_mm=0.003 * np.cos(2 * angle) + 0.001 * rng.normal(size=n))
    return MadePart(f"type {order % TYPES}", str(order), "1", float(order), cut, left, error)


def main() -> None:
    """Prints a prediction's times and its growth."""
    parts = [made(order) for order in range(LONG)]
    today = replace(made(LONG), finish=None, correction_mm=None)

    def predicted(history: list[MadePart], fitted: bool) -> None:
        of_edge._LATEST.clear()
        if fitted:
            _KNOWN.clear()
        expect(history, today, today.semifinish, MemoryOptions())

    contenders = [
        Contender(f"{SHORT} parts, sizes fitted", lambda: predicted(parts[-SHORT:], True)),
        Contender(f"{LONG} parts, sizes fitted", lambda: predicted(parts, True)),
        Contender(f"{LONG} parts, sizes known", lambda: predicted(parts, False)),
        Contender("state known", lambda: expect(parts, today, today.semifinish, MemoryOptions())),
    ]
    verdict(compare("a prediction", contenders, rounds=5), contenders[1].name, contenders[0].name, 1.2)


if __name__ == "__main__":
    main()
