"""Which axis error is wrong: [4773 Table 1] against the machine model, and the judge against residuals typed apart."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.support.refusals import refused
from trueloop.arrays import Array
from trueloop.diagnosis.terms.judge import Verdict, judge, one_after_another
from trueloop.diagnosis.terms.question import question
from trueloop.diagnosis.terms.separators import _designs
from trueloop.diagnosis.terms.suspects import Residuals, with_order
from trueloop.errors import Code
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import State, design
from trueloop.machine.model.term import Term, chain_of

LATHE = chain_of("turning")
ELEMENT = {"X": "cross slide", "Z": "carriage", "C": "spindle"}
TOOLS = ((60.0, -40.0), (40.0, -90.0), (75.0, 10.0))
LEFT: dict[str, Callable[..., tuple[Array | float, Array | float]]] = {
    "EX0C": lambda r, z, xt, zt: (-1.0, 0.0),
    "EXZ": lambda r, z, xt, zt: (1.0, 0.0),
    "EB0C": lambda r, z, xt, zt: (-z, r),
    "EBZ": lambda r, z, xt, zt: (zt, -xt - (r - xt)),
    "EXX": lambda r, z, xt, zt: (1.0, 0.0),
    "EBX": lambda r, z, xt, zt: (zt, -xt),
    "EZ0C": lambda r, z, xt, zt: (0.0, -1.0),
    "EZX": lambda r, z, xt, zt: (0.0, 1.0),
    "EZZ": lambda r, z, xt, zt: (0.0, 1.0),
}
"""(e_r, e_z) for 1 mm or 1 rad, material left on positive, typed from [4773 Eqs 1 and 2]: thirteen that are not 0."""


def _points() -> tuple[Array, Array, Array]:
    """Radius, z and normals of a shaft of three diameters with its faces."""
    z = np.linspace(20, 120, 18)
    shaft = np.repeat([40.0, 30.0, 20.0], 6)
    face = np.concatenate([np.linspace(low, low + 10, 6) for low in (8.0, 20.0, 30.0)])
    normals = np.repeat([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], 18, axis=0)
    return np.r_[shaft, face], np.r_[z, np.repeat([120.0, 86.0, 53.0], 6)], normals


def _seen(
    errors: dict[str, str],
    *,
    parts: int = 6,
    tools: int = 3,
    size_mm: float = 5e-3,
    noise_mm: float = 1.1e-3,
    seed: int = 1,
) -> Residuals:
    """Errors that follow a signal (or "" none), ±5 K, each part set up elsewhere by 0.5 µm."""
    rng = np.random.default_rng(seed)
    r, z, normals = _points()
    signals = {name: rng.uniform(-5, 5, parts) for name in ELEMENT.values()}
    rows, places, points = [], [], []
    for part in range(parts):
        xt, zt = TOOLS[part % tools]
        left = np.zeros(len(r))
        for name, signal in errors.items():
            e_r, e_z = LEFT[name](r, z, xt, zt)
            one = normals[:, 0] * e_r + normals[:, 2] * e_z
            at = (z - zt) / 50 if name.endswith("Z") else (r - xt + 30) / 15
            follows = signals[signal][part] / 3 if signal else np.ones(1) if name.endswith("C") else at
            left = left + size_mm * one / max(np.abs(one).max(), 1.0) * follows
        rows.append(left + normals @ rng.normal(0, 0.5e-3, 3) + rng.normal(0, noise_mm, len(r)))
        places.append(np.column_stack([r - xt, z - zt]))
        points.append(np.tile([xt, 0.0, zt], (len(r), 1)))
    part_of = np.repeat(np.arange(parts), len(r))
    state = State(np.vstack(places), 0.0, {n: v[part_of] for n, v in signals.items()}, np.vstack(points))
    return Residuals(part_of, np.tile(normals, (parts, 1)), state, np.concatenate(rows), ELEMENT)


def _names(verdict: Verdict) -> list[tuple[str, ...]]:
    return [one.names for one in verdict.sets]


@pytest.mark.parametrize("name", LEFT)
def test_influences_are_those_of_table_1(name: str) -> None:
    r, z, normals = _points()
    for xt, zt in TOOLS:
        state = State(np.column_stack([r - xt, z - zt]), 0.0, {}, (xt, 0.0, zt))
        rows = np.einsum("ni,ni->n", normals, design(LATHE, (Term(error_name(name)),), state)[:, :, 0])
        e_r, e_z = LEFT[name](r, z, xt, zt)
        assert rows == pytest.approx(normals[:, 0] * e_r + normals[:, 2] * e_z, abs=1e-9)


def test_nothing_wrong_is_sound() -> None:
    verdict = judge(LATHE, _seen({}))
    assert verdict.sound > 0.8 and not verdict.sets


@pytest.mark.parametrize("name", LEFT)
def test_a_single_wrong_error_is_in_a_set_and_alone_only_if_it_is_the_one(name: str) -> None:
    own = ELEMENT[name[-1]]
    for tools in (1, 3):
        names = _names(judge(LATHE, _seen({name: own}, parts=9, tools=tools)))
        assert len(names) == 1 and name in names[0]


def test_diameters_of_one_tool_leave_a_set_and_another_length_divides_it() -> None:
    whole = _seen({"EBX": "cross slide"}, tools=1)
    verdict = judge(LATHE, _of(whole, whole.normal[:, 0] == 1.0))
    (found,) = verdict.sets
    assert {"EXX", "EBX"} <= set(found.names)
    assert any(
        "tool or stylus longer or shorter" in words and words.endswith("along Z") for words in found.separated_by
    )
    assert any(note.code is Code.DIA_ALIKE for note in verdict.notes)
    with_three = _seen({"EBX": "cross slide"}, tools=3, parts=12)
    (angles,) = judge(LATHE, _of(with_three, with_three.normal[:, 0] == 1.0)).sets
    assert angles.names[0] == "EBX" and set(angles.names) <= {"EBX", "EBZ"}


def test_two_errors_at_once_are_two_sets() -> None:
    names = _names(judge(LATHE, _seen({"EBZ": "carriage", "EZX": ""}, parts=9)))
    assert len(names) == 2
    assert any("EBZ" in one for one in names) and any("EZX" in one for one in names)


def test_one_part_and_few_points_are_refused() -> None:
    seen = _seen({})
    assert refused(judge, LATHE, _of(seen, seen.part == 0)).code is Code.DIA_FEW
    assert refused(judge, LATHE, _of(seen, np.arange(len(seen.part)) % 36 == 0)).code is Code.DIA_FEW


def test_missing_temperatures_and_values_that_are_not_finite_are_refused() -> None:
    seen = _seen({})
    assert refused(judge, LATHE, replace(seen, element={**ELEMENT, "X": "T9"})).code is Code.DIA_SIGNAL
    with_gap = {**seen.state.signals, "carriage": np.where(seen.part == 2, np.nan, 20.0)}
    refusal = refused(judge, LATHE, replace(seen, state=replace(seen.state, signals=with_gap)))
    assert refusal.code is Code.DIA_SIGNAL and refusal.values["parts"] == [2]
    holed = np.where(np.arange(len(seen.part)) == 4, np.nan, seen.residual_mm)
    assert refused(judge, LATHE, replace(seen, residual_mm=holed)).code is Code.DIA_POINTS


def _of(seen: Residuals, rows: Array) -> Residuals:
    state = seen.state
    signals = {name: np.asarray(values)[rows] for name, values in state.signals.items()}
    at = State(state.positions[rows], 0.0, signals, np.asarray(state.tool_mm)[rows])
    return Residuals(seen.part[rows], seen.normal[rows], at, seen.residual_mm[rows], seen.element)


def test_one_correlation_after_another_names_the_largest_first() -> None:
    seen = _seen({"EZX": "cross slide"}, parts=9)
    first, *_ = one_after_another(LATHE, seen)
    assert (first.error, first.signal) == ("EZX", "cross slide")
    assert first.correlation > 0.5
    assert one_after_another(LATHE, replace(seen, residual_mm=np.zeros_like(seen.residual_mm))) == ()


def test_a_longer_tool_is_imagined_at_the_same_place_of_the_part() -> None:
    """The axis stands back by what the tool is longer: else other positions would divide, not the length."""
    seen, rows = _seen({}), np.arange(4)
    tool = np.asarray(seen.state.tool_mm)[rows][:, [0, 2]]
    first, second, *_ = _designs(question(LATHE, with_order(seen), turned=False), rows)
    for imagined, axis in ((first, 0), (second, 1)):
        longer = np.asarray(imagined.state.tool_mm)[:, [0, 2]] - tool
        assert (longer[:, axis] > 1.0).all() and (longer[:, 1 - axis] == 0.0).all()
        assert np.allclose(imagined.state.positions + longer, seen.state.positions[rows])
