"""A 21-term volumetric model at one point and at a million, against numpy and plain Python as a user would write them.

Run: .venv/bin/python -m benches.machine_evaluator
"""

from dataclasses import replace

import numpy as np

from benches.ratio import Contender, compare, verdict
from trueloop.arrays import Array
from trueloop.machine.model.compiled import compile_model
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import chain_of, mill_terms

TRAVEL = {"X": (0.0, 500.0), "Y": (-200.0, 200.0), "Z": (-300.0, 0.0)}
POINTS = 1_000_000


def mill_model(rng: np.random.Generator) -> MachineModel:
    """A three-axis mill with errors of some 0.01 mm in all 21 terms."""
    chain = chain_of("w b X Y Z t")
    chain = chain.with_axes({a.name: replace(a, travel=TRAVEL[a.name]) for a in chain.axes})
    terms = mill_terms(chain)
    terms = tuple(
        replace(t, parts=tuple(replace(p, basis=replace(p.basis, zero_at=())) for p in t.parts)) for t in terms
    )
    size = sum(term.size for term in terms)
    scale = np.concatenate([np.full(t.size, 3e-5 if t.name.is_rotation else 0.015) for t in terms])
    return MachineModel(Machine("mill", chain), terms, rng.normal(0, 1, size) * scale, np.zeros((size, size)))


def _cubics(model: MachineModel) -> tuple[Array, Array]:
    """The same model as numpy users hold it: (18, 4) cubics in position, highest power first, and three angles."""
    cubics = []
    for term, where in zip(model.terms, model.slices(), strict=True):
        if not term.name.place:
            at = np.linspace(*TRAVEL[term.name.axis], 9)
            cubics.append(np.polyfit(at, term.values(model.coefficients[where], at, np.zeros(9), {}), 3))
    return np.array(cubics), model.coefficients[-3:]


def _numpy_error(cubics: Array, square: Array, q: Array) -> Array:
    x, y, z = q.T
    e = [np.polyval(c, axis) for c, axis in zip(cubics, [x] * 6 + [y] * 6 + [z] * 6, strict=True)]
    (exx, eyx, ezx, eax, ebx, ecx), (exy, eyy, ezy, eay, eby, ecy), (exz, eyz, ezz, *_) = e[:6], e[6:12], e[12:]
    ec0y, eb0z, ea0z = square
    a, b, c = eax + eay, ebx + eby, ecx + ecy
    return np.stack(
        [
            exx + exy + exz + b * z - ecx * y - ec0y * y + eb0z * z,
            eyx + eyy + eyz + 0 * c - a * z - ea0z * z,
            ezx + ezy + ezz + eax * y,
        ],
        axis=1,
    )


def _plain_error(cubics: list[list[float]], square: list[float], q: tuple[float, float, float]) -> tuple[float, ...]:
    x, y, z = q
    e = [((c[0] * p + c[1]) * p + c[2]) * p + c[3] for c, p in zip(cubics, (x,) * 6 + (y,) * 6 + (z,) * 6, strict=True)]
    a, b = e[3] + e[9], e[4] + e[10]
    return (
        e[0] + e[6] + e[12] + b * z - e[5] * y - square[0] * y + square[1] * z,
        e[1] + e[7] + e[13] - a * z - square[2] * z,
        e[2] + e[8] + e[14] + e[3] * y,
    )


def main() -> None:
    """Both tables, the same numbers checked first."""
    rng = np.random.default_rng(1)
    model = mill_model(rng)
    compiled = compile_model(model, {})
    cubics, square = _cubics(model)
    points = np.stack([rng.uniform(*TRAVEL[axis], POINTS) for axis in "XYZ"], axis=1)
    off = np.abs(compiled.error_mm(points[:1000]) - _numpy_error(cubics, square, points[:1000])).max()
    assert off < 1e-10, off
    many = compare(
        f"21 terms, {POINTS:,} points",
        [
            Contender("trueloop, 1 thread", lambda: compiled.error_mm(points)),
            Contender("trueloop, 2 threads", lambda: compiled.error_mm(points, threads=2)),
            Contender("numpy polyval", lambda: _numpy_error(cubics, square, points)),
        ],
        rounds=7,
    )
    verdict(many, "trueloop, 1 thread", "numpy polyval", 0.1)
    one, plain = points[:1].copy(), (cubics.tolist(), square.tolist(), (10.0, 20.0, -30.0))
    compare(
        "21 terms, one point, called from Python (inside Rust: cargo run --release --example time_point)",
        [
            Contender("trueloop", lambda: compiled.error_mm(one)),
            Contender("plain Python", lambda: _plain_error(*plain)),
            Contender("numpy polyval", lambda: _numpy_error(cubics, square, one)),
        ],
        rounds=7,
    )


if __name__ == "__main__":
    main()
