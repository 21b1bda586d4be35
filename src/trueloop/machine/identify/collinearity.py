"""The parts of a model that the readings cannot separate: condition indices and variance shares [Belsley 1980, ch. 3].

Each part (and each way of travel) is made orthonormal by itself first, so that only likeness *between* parts counts:
two temperature sensors that moved together, or two errors that no reading distinguishes.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.machine.model.term import Term

WARN_INDEX = 30.0
"""Condition index from which Belsley calls the likeness strong."""

REFUSE_INDEX = 1e7
"""Beyond this the difference of two parts is rounding."""

SHARE = 0.5
"""Share of a part's variance that one combination must take for the part to belong to it [Belsley]."""


def collinear_findings(terms: Sequence[Term], rows: Array, before: Array | None = None) -> list[Finding]:
    """Warnings about parts of `terms` that are hardly distinguishable in `rows` (n, free); raises MCH-COLLINEAR.

    The columns of `rows` are the free parameters in the order of `Term.admissible`; `before` are the same where
    something was taken out of them: what that leaves of a part is measured by what the part was.
    """
    names, blocks = _blocks(terms, rows)
    wholes = blocks if before is None else _blocks(terms, before)[1]
    left, sizes = [], []
    for name, block, whole in zip(names, blocks, wholes, strict=True):
        basis, strength, _ = np.linalg.svd(block, full_matrices=False)
        most = float(np.linalg.norm(whole, 2))
        if strength[-1] <= most / REFUSE_INDEX:
            raise _refusal([name], float("inf") if strength[-1] == 0 else most / float(strength[-1]))
        left.append(basis)
        sizes.append(basis.shape[1])
    strength, directions = _spectrum(np.hstack(left))
    owner = np.repeat(np.arange(len(names)), sizes)
    findings = []
    for index, members in _combinations(strength, directions, owner):
        involved = [names[k] for k in members]
        if index > REFUSE_INDEX:
            raise _refusal(involved, index)
        findings.append(_warning(involved, index))
    return findings


def _blocks(terms: Sequence[Term], rows: Array) -> tuple[list[str], list[Array]]:
    names, blocks, start = [], [], 0
    for term in terms:
        ways = ["forward ", "return "] if term.both_ways else [""]
        for way in ways:
            for part in term.parts:
                free = part.basis.size if way == "return " else part.basis.admissible().shape[1]
                if free:
                    names.append(f"{way}{term.name}" + (f"·{part.signal}" if part.signal else ""))
                    blocks.append(rows[:, start : start + free])
                start += free
    return names, blocks


def _spectrum(matrix: Array) -> tuple[Array, Array]:
    """Returns singular values and right vectors; a value that rounding decides counts as its size."""
    _, strength, directions = np.linalg.svd(matrix, full_matrices=False)
    return np.maximum(strength, strength[0] * np.finfo(float).eps), directions


def _combinations(strength: Array, directions: Array, owner: NDArray[np.intp]) -> list[tuple[float, list[int]]]:
    """Returns weak combinations, strongest likeness first: (condition index, the parts whose variance it makes up)."""
    parts = range(int(owner.max()) + 1)
    variance = directions**2 / strength[:, None] ** 2
    by_part = np.stack([variance[:, owner == k].sum(axis=1) for k in parts], axis=1)
    shares = by_part / by_part.sum(axis=0)
    found = []
    for row in np.argsort(strength):
        index = float(strength[0] / strength[row])
        if index <= WARN_INDEX:
            break
        members = [k for k in parts if shares[row, k] > SHARE / 2]
        if members:
            found.append((index, members))
    return found


def _warning(names: list[str], index: float) -> Finding:
    return Finding(
        Severity.WARNING,
        Code.MCH_COLLINEAR,
        f"{' and '.join(names)} are hardly separated by these readings (condition index {index:.0f})",
        hint="measure where they differ (another tool length, another warm-up), or leave one out",
        values={"parameters": names},
    )


def _refusal(names: list[str], index: float) -> TrueloopError:
    return TrueloopError(
        Code.MCH_COLLINEAR,
        f"{' and '.join(names)} cannot be separated by these readings (condition index {index:.1e})",
        hint="leave one out: keep the sensor nearest the heat source, or one of two errors with the same effect",
        values={"parameters": names},
    )
