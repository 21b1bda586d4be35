"""What an edge has taught, against the model written out with plain loops, and against what is predicted by it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tests.support.kept import EDGE, MADE_AT
from trueloop.arrays import Array
from trueloop.domain.edge_life import EdgeLife
from trueloop.domain.life import EdgeEvent, EdgeEventKind
from trueloop.memory.edge.learnt import Learnt, learnt
from trueloop.memory.edge.predict import predict, sizes
from trueloop.memory.made_part import ArcErrors, MadePart
from trueloop.report.tool import ShownEdge, form_figure, transfer_figure

ANGLES = np.radians(np.linspace(5.0, 85.0, 7))


def arc(angle: Array, error_um: Array) -> ArcErrors:
    n = len(angle)
    return ArcErrors(("dome",) * n, tuple(map(str, range(n))), angle, error_um / 1000, np.full(n, 3e-4))


def form_um(angle: Array) -> Array:
    return 12 * np.cos(3 * angle)


def history(seed: int = 1, parts: int = 6, noise_um: float = 1.0) -> list[MadePart]:
    """Two part types and two settings; the finish cut leaves 6 µm more, and 4 µm along x with the second type."""
    random = np.random.default_rng(seed)
    made = []
    for k in range(parts):
        angle = ANGLES + random.uniform(-0.03, 0.03, len(ANGLES))
        setting, part_type = ("new" if k >= 4 else "old"), ("B" if k % 2 else "A")
        offset = {"old": (5.0, -8.0), "new": (-20.0, 15.0)}[setting]
        common = form_um(angle) + offset[0] * np.sin(angle) + offset[1] * np.cos(angle)
        semifinish = common + random.normal(0, noise_um, len(angle))
        finish = common + 6.0 + (4.0 * np.sin(angle) if part_type == "B" else 0.0)
        taken = semifinish.copy()  # corrected by its own touches
        made.append(
            MadePart(
                part_type,
                f"{k}",
                setting,
                float(k),
                arc(angle, semifinish),
                arc(angle, finish - taken + random.normal(0, noise_um, len(angle))),
                taken / 1000,
                minutes_in_cut=3.0 * k,
            )
        )
    return made


def found(parts: list[MadePart]) -> Learnt:
    result = learnt(parts, ANGLES)
    assert result is not None
    return result


Covariance = Callable[[tuple[int, bool], float, tuple[int, bool], float], float]


def written_out(parts: list[MadePart], ask: Covariance) -> tuple[Array, Array]:
    """Mean and standard uncertainty at ANGLES of the term of which `ask` is the covariance; part len(parts) asks."""
    size = sizes(parts)

    def matern(a: float, b: float, length: float) -> float:
        r = 5**0.5 * abs(a - b) / length
        return float((1 + r + r * r / 3) * np.exp(-r))

    def full(one: tuple[int, bool], a: float, two: tuple[int, bool], b: float) -> float:
        (i, fi), (j, fj) = one, two
        p, q, cos = parts[i], parts[j], float(np.cos(a - b))
        shape, of_finish = matern(a, b, size["angle_rad"]), matern(a, b, size["finish_angle_rad"])
        both = 1.0 if fi and fj else 0.0
        same_setting, same_type = float(p.setting == q.setting), float(p.part_type == q.part_type)
        first = {"old": 0, "new": 4}
        since = min(i - first[p.setting], j - first[q.setting])
        value = size["nose_mm"] ** 2 * shape + size["wear_mm"] ** 2 * min(i, j) * shape
        value += size["setting_mm"] ** 2 * (same_setting + same_type) / 2 * cos
        value += size["walk_mm"] ** 2 * same_setting * since * cos
        value += both * (size["finish_mm"] ** 2 + size["finish_type_mm"] ** 2 * same_type) * (of_finish + cos)
        if i == j:
            value += size["part_mm"] ** 2 * shape + size["clamping_mm"] ** 2 * cos
            value += both * size["finish_part_mm"] ** 2 * (of_finish + cos)
        return value

    seen: list[tuple[tuple[int, bool], float, float, float, float]] = []
    for k, part in enumerate(parts):
        assert part.finish is not None and part.correction_mm is not None
        for errors, finish, taken in (
            (part.semifinish, False, 0.0 * part.correction_mm),
            (part.finish, True, part.correction_mm),
        ):
            for a, e, u, c in zip(errors.contact_angle_rad, errors.error_mm, errors.standard_u_mm, taken, strict=True):
                seen.append(((k, finish), float(a), float(e + c), float(u), float(c)))
    n = len(seen)
    k_yy = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            k_yy[i, j] = (
                full(seen[i][0], seen[i][1], seen[j][0], seen[j][1]) + size.gain_sd**2 * seen[i][4] * seen[j][4]
            )
        k_yy[i, i] += size["noise_mm"] ** 2 + seen[i][3] ** 2 + 1e-10
    y = np.array([one[2] for one in seen])
    asks = (len(parts), False)
    across = np.array([[ask(asks, float(a), cut, b) for cut, b, *_ in seen] for a in ANGLES])
    alone = np.array([ask(asks, float(a), asks, float(a)) for a in ANGLES])
    inverse = np.linalg.inv(k_yy)
    return across @ inverse @ y, np.sqrt(alone - np.einsum("ij,jk,ik->i", across, inverse, across))


def test_terms_are_those_of_the_model_written_out() -> None:
    parts = history()
    result, size = found(parts), sizes(parts)
    last = len(parts) - 1

    def shape(a: float, b: float, angle: str = "angle_rad") -> float:
        r = 5**0.5 * abs(a - b) / size[angle]
        return float((1 + r + r * r / 3) * np.exp(-r))

    def form(_: tuple[int, bool], a: float, two: tuple[int, bool], b: float) -> float:
        return (size["nose_mm"] ** 2 + size["wear_mm"] ** 2 * min(last, two[0])) * shape(a, b)

    def transfer(one: tuple[int, bool], a: float, two: tuple[int, bool], b: float) -> float:
        return (
            size["finish_mm"] ** 2 * (two[1] or one == two) * (shape(a, b, "finish_angle_rad") + float(np.cos(a - b)))
        )

    def of_type(one: tuple[int, bool], a: float, two: tuple[int, bool], b: float) -> float:
        if one != two and parts[two[0]].part_type != "B":
            return 0.0
        both = float(two[1] or one == two)
        cos = float(np.cos(a - b))
        return size["setting_mm"] ** 2 / 2 * cos + both * size["finish_type_mm"] ** 2 * (
            shape(a, b, "finish_angle_rad") + cos
        )

    for term, ask in ((result.form, form), (result.transfer, transfer), (result.by_type["B"], of_type)):
        mean, u = written_out(parts, ask)
        np.testing.assert_allclose(term.mean_mm, mean, atol=2e-7)
        np.testing.assert_allclose(term.u_mm, u, atol=2e-6)


def test_the_setting_is_that_of_the_model_written_out() -> None:
    parts = history()
    result, size = found(parts), sizes(parts)

    def along(x: float) -> Covariance:
        """o·(cos x, sin x) … of the present setting: its covariance with an error at b, and with itself."""

        def ask(one: tuple[int, bool], _: float, two: tuple[int, bool], b: float) -> float:
            walked = {4: 0, 5: 1}.get(two[0], 1)
            variance = size["setting_mm"] ** 2 / 2 + size["walk_mm"] ** 2 * (1 if one == two else walked)
            if one == two:
                return variance
            return variance * float(np.cos(x - b)) if two[0] >= 4 else 0.0

        return ask

    for place, angle in enumerate((np.pi / 2, 0.0)):
        mean, u = written_out(parts, along(angle))
        assert result.setting_mm[place] == pytest.approx(mean[0], abs=2e-7)
        assert result.setting_u_mm[place] == pytest.approx(u[0], abs=2e-6)


def test_signs_and_sizes_of_what_was_put_in() -> None:
    """Several histories: the setting's change, the transfer and the second type's share are found with their signs."""
    changes, unsure, transfers, types = [], [], [], []
    for seed in range(4):
        parts = history(seed, parts=8)
        result = found(parts)
        before = found(parts[:4])
        changes.append(1000 * (result.setting_mm - before.setting_mm))
        unsure.append(1000 * np.hypot(result.setting_u_mm, before.setting_u_mm))
        both = result.by_type["A"].mean_mm, result.by_type["B"].mean_mm
        transfers.append(1000 * np.mean(result.transfer.mean_mm + (both[0] + both[1]) / 2))
        types.append(1000 * (both[1] - both[0]))
    # The new setting is (-25, +23) µm from the old one, as far as it can be separated from the form and the part types.
    assert np.all(np.abs(np.array(changes) - [-25.0, 23.0]) < 2 * np.array(unsure))
    assert np.all(np.mean(changes, axis=0) * [-1, 1] > 10)
    assert np.mean(types, axis=0)[-1] == pytest.approx(4.0, abs=1.5)  # at 85° along x
    assert abs(np.mean(types, axis=0)[0]) < 1.5  # at 5° hardly
    assert np.mean(transfers) == pytest.approx(6.0 + 2.0 * np.mean(np.sin(ANGLES)), abs=3.0)


def test_form_and_setting_make_up_what_is_predicted_of_a_part_of_a_new_type() -> None:
    """Before its touches, memory predicts of a new type's semi-finish cut w + o, and nothing else."""
    parts = history()
    result = found(parts)
    n = len(ANGLES)
    asked = replace(
        parts[-1], part_type="C", serial="9", semifinish=arc(ANGLES, np.zeros(n)), finish=None, correction_mm=None
    )
    predicted = predict(parts, asked).before.mean_mm[:n]
    setting = result.setting_mm[0] * np.sin(ANGLES) + result.setting_mm[1] * np.cos(ANGLES)
    np.testing.assert_allclose(predicted, result.form.mean_mm + setting, atol=1e-9)


def test_in_all_is_what_is_predicted_of_a_next_part_of_the_type() -> None:
    """Without its touches; the terms add up to it."""
    parts = history()
    result, n = found(parts), len(ANGLES)
    none = ArcErrors.none()
    asked = replace(parts[-1], part_type="A", serial="9", semifinish=none, finish=arc(ANGLES, np.zeros(n)))
    predicted = predict(parts, replace(asked, correction_mm=np.zeros(n))).after.mean_mm
    np.testing.assert_allclose(predicted, result.in_all["A"].mean_mm, atol=1e-9)
    setting = result.setting_mm[0] * np.sin(ANGLES) + result.setting_mm[1] * np.cos(ANGLES)
    total = result.form.mean_mm + setting + result.transfer.mean_mm + result.by_type["A"].mean_mm
    np.testing.assert_allclose(total, result.in_all["A"].mean_mm, atol=1e-9)
    assert np.max(result.in_all["A"].u_mm) < np.min(result.form.u_mm)
    own = np.array([name == "B" for name in result.behind.part_type])
    at = learnt(parts, result.behind.contact_angle_rad[own])
    assert at is not None
    np.testing.assert_allclose(at.in_all["B"].mean_mm, result.in_all_at_mm[own], atol=1e-9)


def test_what_is_left_is_what_the_terms_do_not_explain() -> None:
    """Points about a curve scatter by the noise that was put in, and the band widens where nothing was seen."""
    parts = history(parts=8, noise_um=2.0)
    result = found(parts)
    assert 0.5 < 1000 * np.std(result.behind.left_mm) < 2.5
    assert len(result.behind.serial) == len(result.behind.finish) == 8 * 2 * len(ANGLES)
    far = learnt(parts, np.radians([45.0, 150.0]))
    assert far is not None and far.form.u_mm[1] > 1.3 * far.form.u_mm[0]
    assert far.nearest_rad[1] == pytest.approx(np.radians(150.0) - max(result.behind.contact_angle_rad))


def test_an_edge_that_cut_nothing_has_taught_nothing() -> None:
    assert learnt([], ANGLES) is None
    part = replace(history()[0], semifinish=ArcErrors.none(), finish=None, correction_mm=None)
    assert learnt([part], ANGLES) is None


def test_parts_without_finish_inspection_teach_the_form_alone() -> None:
    parts = [replace(part, finish=None, correction_mm=None) for part in history()]
    result = found(parts)
    assert result.inspected == 0 and result.parts == 6
    np.testing.assert_allclose(result.transfer.mean_mm, 0.0, atol=1e-12)
    assert np.min(result.transfer.u_mm) > np.max(found(history()).transfer.u_mm)


def test_a_touch_with_more_material_is_drawn_above_the_curve() -> None:
    """One touch of the third part stands 6 µm higher than before: what is left of it, and its dot, rise."""
    for finish, draw in ((False, form_figure), (True, transfer_figure)):
        parts = history(parts=8)
        place = (2 * 2 + finish) * len(ANGLES) + 3
        errors = parts[2].finish if finish else parts[2].semifinish
        assert errors is not None
        high = replace(errors, error_mm=errors.error_mm + np.where(np.arange(len(ANGLES)) == 3, 0.006, 0.0))
        before = found(parts)
        parts[2] = replace(parts[2], finish=high) if finish else replace(parts[2], semifinish=high)
        result = found(parts)
        assert result.behind.finish[place] == finish and result.behind.serial[place] == "2"
        assert result.behind.left_mm[place] - before.behind.left_mm[place] > 0.001
        life = EdgeLife((EdgeEvent(EDGE, EdgeEventKind.MOUNTED, MADE_AT),))
        dots = [
            trace for trace in draw(ShownEdge(life, (), result, (), None, 0.1), result)["data"] if "marker" in trace
        ]
        height = {text: y for trace in dots for text, y in zip(trace["hovertext"], trace["y"], strict=True)}
        angle = np.degrees(result.behind.contact_angle_rad[place])
        (own,) = (y for text, y in height.items() if text.startswith("part 2 ") and f"{angle:.1f}°" in text)
        at_mm = (result.transfer_at_mm if finish else result.form_at_mm)[place]
        assert own - 1000 * at_mm == pytest.approx(1000 * result.behind.left_mm[place], abs=1e-9)
