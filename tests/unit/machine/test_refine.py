"""A model refined from parts, against tool points of plain transforms that know nothing of the model."""

from dataclasses import replace

import numpy as np
import pytest

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.chain import Axis, AxisKind
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.names import error_name
from trueloop.machine.model.position_basis import CONSTANT, polynomial
from trueloop.machine.model.structure import chain_of
from trueloop.machine.model.term import Part, Term
from trueloop.machine.refine.changed import changes
from trueloop.machine.refine.guilty import Guilty, with_guilty
from trueloop.machine.refine.left import LeftOnParts, newer_more
from trueloop.machine.refine.refine import refine, require_better
from trueloop.machine.refine.update import update

TOOLS = np.array([[-12.0, -30.0], [-70.0, 60.0], [-40.0, 10.0]])


def lathe_model(u_mm: float = 2e-4) -> MachineModel:
    """A turning centre whose model says that it has no errors, sure of that to `u_mm`."""
    chain = chain_of("turning").with_axes(
        {
            "X": Axis("X", AxisKind.LINEAR, 0, travel=(-10.0, 310.0)),
            "Z": Axis("Z", AxisKind.LINEAR, 2, travel=(-300.0, 110.0)),
        }
    )
    terms = (
        Term(error_name("EXX"), (Part(polynomial(-10.0, 310.0, 2)),)),
        Term(error_name("EXZ"), (Part(polynomial(-300.0, 110.0, 3)),), both_ways=True),
        Term(error_name("EZ0C"), (Part(CONSTANT), Part(CONSTANT, "T1", 20.0))),
    )
    size = sum(term.size for term in terms)
    known = {"X": (-10.0, 310.0), "Z": (-300.0, 110.0), "T1": (20.0, 44.0)}
    return MachineModel(Machine("lathe", chain, "4711"), terms, np.zeros(size), u_mm**2 * np.eye(size), known)


def straightness(slides: Array, tool: Array, warm: Array) -> Array:
    """The carriage goes 12 µm towards larger X in the middle of its way."""
    return np.column_stack([0.012 * np.sin(np.pi * (slides[:, 1] + 300) / 410), np.zeros(len(slides))])


def yaw(slides: Array, tool: Array, warm: Array) -> Array:
    """The carriage turns about Y by r = 100 µrad · z/300: a point dx, dz off its frame moves by r · (dz, −dx)."""
    turn = 1e-4 * slides[:, 1] / 300
    return np.column_stack([turn * tool[:, 1], -turn * (slides[:, 0] + tool[:, 0])])


def growth(slides: Array, tool: Array, warm: Array) -> Array:
    """The spindle takes the work by 0.8 µm/K along +Z: the tool stands that much less along Z on it."""
    return np.column_stack([np.zeros(len(slides)), -0.0008 * (warm - 20.0)])


def nothing(slides: Array, tool: Array, warm: Array) -> Array:
    return np.zeros((len(slides), 2))


def cut(model: MachineModel, truth, seed: int, parts: int = 12, noise_mm: float = 1e-3) -> LeftOnParts:  # type: ignore[no-untyped-def]
    """Parts of three types, cut with the command moved by −E_model; what stands off the nominal surface is measured."""
    rng, rows = np.random.default_rng(seed), []
    for part in range(parts):
        kind, warm = part % 3, rng.uniform(21, 44)
        begin, radius = (-180.0, -150.0, -120.0)[kind], (90.0, 60.0, 110.0)[kind]
        for k, tool in enumerate(TOOLS[[kind, (kind + 1) % 3]]):
            for t in range(8):
                rows.append((part, kind, warm, radius - 20 * k, begin + 40 * k + 4 * t, 1.0, 0.0, *tool))
                rows.append((part, kind, warm, radius - 20 * k - 2 * t, begin + 40 * k + 40, 0.0, 1.0, *tool))
    table = np.array(rows)
    number, types, heat = table[:, 0].astype(int), table[:, 1].astype(int), table[:, 2]
    point, normal, own = table[:, 3:5], table[:, 5:7], table[:, 7:9]
    spread = np.zeros((2, len(table), 3))
    spread[:, :, [0, 2]] = normal, own
    state = State(point - own, 0.0, {"T1": heat}, spread[1])
    slides = point - own - model.error_mm(state)[:, [0, 2]]
    surface = slides + own + truth(slides, own, heat)
    left = np.sum(normal * (surface - point), axis=1) + rng.normal(0, noise_mm, len(table))
    set_up = rng.normal(0, noise_mm, (parts, 2))[number]
    left = left + np.sum(normal * set_up, axis=1)
    return LeftOnParts(number, types, spread[0], state, left)


def left_truly(model: MachineModel, truth, seed: int = 99) -> float:  # type: ignore[no-untyped-def]
    """RMS of what the model leaves on other parts without noise, µm."""
    return 1e3 * float(np.sqrt(np.mean(cut(model, truth, seed, 9, 1e-9).residual_mm ** 2)))


CASES = [
    (straightness, Guilty(error_name("EXZ"))),
    (yaw, Guilty(error_name("EBZ"))),
    (growth, Guilty(error_name("EZ0C"), "T1")),
]


@pytest.mark.parametrize(("truth", "guilty"), CASES)
def test_a_refined_model_leaves_less_than_half(truth, guilty: Guilty) -> None:  # type: ignore[no-untyped-def]
    """Wrong by a sign it would leave twice as much."""
    model = lathe_model()
    before = left_truly(model, truth)
    found = refine(model, cut(model, truth, 1), [guilty])
    assert before > 2.0
    assert left_truly(found.model, truth) < 0.25 * before
    assert found.judged.better and found.judged.by_type is not None
    assert found.judged.by_type.rms_new_mm < found.judged.by_type.rms_old_mm


def test_a_correction_in_force_is_not_made_twice() -> None:
    """Refined again from parts cut with the refined model, it stays where it is."""
    model = lathe_model()
    once = update(model, cut(model, straightness, 1), CASES[0][1:]).model
    twice = update(once, cut(once, straightness, 2), CASES[0][1:]).model
    assert left_truly(twice, straightness) < left_truly(once, straightness) + 0.3


def test_a_sound_model_stays() -> None:
    model = lathe_model()
    found = refine(model, cut(model, nothing, 1), [CASES[0][1]])
    assert left_truly(found.model, nothing) < 0.5
    assert not found.judged.better
    with pytest.raises(TrueloopError) as refused:
        require_better(found)
    assert refused.value.code is Code.DIA_WORSE and refused.value.override == "--accept DIA-WORSE"
    require_better(found, [Code.DIA_WORSE])


def test_the_update_is_that_of_bayes() -> None:
    """One constant known to 2 µm, seen by points that scatter by s: the weight is 4 n / (4 n + s²)."""
    chain = lathe_model().machine.chain
    model = MachineModel(Machine("lathe", chain), (Term(error_name("EX0C")),), np.zeros(1), np.array([[4e-6]]))
    n = 6
    rng = np.random.default_rng(0)
    values = rng.normal(0.003, 0.001, n)
    seen = LeftOnParts(
        np.arange(n),
        np.zeros(n, int),
        np.tile([1.0, 0.0, 0.0], (n, 1)),
        State(rng.uniform(0, 100, (n, 2))),
        values,
        0.001,
    )
    found = update(model, seen, [])
    gain = 4e-6 * n / (4e-6 * n + found.noise_mm**2 + found.set_up_mm**2)
    assert -found.model.coefficients[0] == pytest.approx(gain * values.mean(), rel=0.08)
    half = update(model, seen, [], share=0.5)
    assert half.model.coefficients[0] == pytest.approx(0.5 * found.model.coefficients[0])
    assert half.model.covariance[0, 0] > found.model.covariance[0, 0]


def test_a_few_slipped_points_hardly_count() -> None:
    model = lathe_model()
    seen = cut(model, straightness, 1)
    values = seen.residual_mm.copy()
    slipped = np.arange(5, len(values), 40)
    values[slipped] += 0.2
    found = update(model, replace(seen, residual_mm=values), [CASES[0][1]])
    assert set(np.flatnonzero(found.outlier)) == set(slipped)
    assert left_truly(found.model, straightness) < 0.3 * left_truly(model, straightness)


def test_what_the_model_lacks_is_added_without_changing_what_it_says() -> None:
    model = lathe_model()
    rng = np.random.default_rng(5)
    model = replace(model, coefficients=rng.normal(0, 1e-3, len(model.coefficients)))
    seen = cut(model, nothing, 1)
    grown = with_guilty(model, [Guilty(error_name("EBX"), "T1"), Guilty(error_name("EXZ"), "T1")], seen.state)
    for travel in (-1.0, 0.0, 1.0):
        state = replace(seen.state, travel=travel)
        assert np.abs(grown.error_mm(state) - model.error_mm(state)).max() < 1e-12
        assert np.abs(grown.standard_u_mm(state) - model.standard_u_mm(state)).max() < 1e-12
    assert len(grown.coefficients) == len(model.coefficients) + 3 + 2 + 2 * 2


def test_changes_say_where_and_by_how_much() -> None:
    model = lathe_model()
    found = refine(model, cut(model, straightness, 1), [CASES[0][1]])
    rows = {round(row.at, 1): row for row in changes(model, found.model) if str(row.error) == "EXZ"}
    middle = rows[-95.0]
    assert 1e3 * middle.change == pytest.approx(12.0, abs=max(3e3 * middle.u, 1.0))
    assert 0.0 < middle.u < 2e-3


def test_newer_parts_count_more() -> None:
    assert newer_more(np.array([3, 3, 5, 9]), 1.0) == pytest.approx([0.25, 0.25, 0.5, 1.0])


def test_weights_count_as_numbers_of_points() -> None:
    """A change of the machine between the parts: with the weights of the newer ones the model follows them."""
    model = lathe_model()
    before, after = cut(model, nothing, 1), cut(model, straightness, 2)
    both = replace(
        after,
        part=np.concatenate([before.part, after.part + 100]),
        part_type=np.tile(after.part_type, 2),
        normal=np.tile(after.normal, (2, 1)),
        state=replace(
            after.state,
            positions=np.tile(after.state.positions, (2, 1)),
            tool_mm=np.tile(np.asarray(after.state.tool_mm), (2, 1)),
            signals={"T1": np.concatenate([before.state.signals["T1"], after.state.signals["T1"]])},
        ),
        residual_mm=np.concatenate([before.residual_mm, after.residual_mm]),
    )
    newer = replace(both, weight=newer_more(both.part, 3.0))
    plain, followed = (update(model, seen, [CASES[0][1]]).model for seen in (both, newer))
    assert left_truly(followed, straightness) < 0.8 * left_truly(plain, straightness)


def test_too_few_parts_and_points_that_do_not_belong_together() -> None:
    model = lathe_model()
    seen = cut(model, nothing, 1)
    with pytest.raises(TrueloopError) as refused:
        refine(model, seen.only(seen.part < 2), [])
    assert refused.value.code is Code.DIA_FEW
    with pytest.raises(TrueloopError) as refused:
        refine(model, replace(seen, residual_mm=seen.residual_mm[:-1]), [])
    assert refused.value.code is Code.MCH_SHAPE
    with pytest.raises(TrueloopError) as refused:
        refine(model, seen, [error_name("EYY")])
    assert refused.value.code is Code.MCH_AXIS
