"""A model refined from parts, against tool points of plain transforms that know nothing of the model."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from tests.support.worn_lathe import cut, growth, lathe_model, left_truly, nothing, straightness, yaw
from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import Term
from trueloop.machine.refine.left import Guilty, LeftOnParts, UpdatedTerm, changes, update, with_guilty
from trueloop.machine.refine.refine import _whitened, refine, require_better

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
    prior = 4e-6 * found.wider**2
    scatter = (found.noise_mm**2 + found.set_up_mm**2) / n
    assert found.model.covariance[0, 0] == pytest.approx(prior * scatter / (prior + scatter), rel=0.3)
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
    _, age = np.unique(-both.part, return_inverse=True)
    newer = replace(both, weight=0.5 ** (age / 3.0))
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


def test_parts_left_out_are_judged_as_if_their_points_were_independent() -> None:
    """Set-ups and noise drawn with the sizes that were found: whitened, every direction scatters by 1."""
    rng = np.random.default_rng(4)
    normal = np.tile([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], (6, 1))
    part, draws = np.repeat([0, 1], 6), 20_000
    seen = LeftOnParts(part, np.zeros(12, int), normal, State(np.zeros((12, 2))), np.zeros(12))
    sizes = SimpleNamespace(noise_mm=0.001, place_mm=0.0005, set_up_mm=0.004)
    along = seen.set_ups() @ (sizes.set_up_mm * rng.standard_normal((seen.set_ups().shape[1], draws)))
    own = np.hypot(sizes.noise_mm, sizes.place_mm) * rng.standard_normal((12, draws))
    white = _whitened(seen, along + own, cast(UpdatedTerm, sizes))
    assert np.allclose(np.cov(white), np.eye(12), atol=0.05)
