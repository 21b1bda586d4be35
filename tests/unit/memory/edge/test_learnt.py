"""What an edge has taught: errors with known offsets, and what is predicted by it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.support.kept import EDGE, MADE_AT
from trueloop.arrays import Array
from trueloop.domain.life import EdgeEvent, EdgeEventKind, EdgeLife
from trueloop.memory.edge.learnt import EdgeKnowledge, learnt
from trueloop.memory.edge.predict import predict
from trueloop.memory.made_part import CutErrors, MadePart
from trueloop.report.tool import ShownEdge, form_figure, transfer_figure

ANGLES = np.radians(np.linspace(5.0, 85.0, 7))


def arc(angle: Array, error_um: Array) -> CutErrors:
    n = len(angle)
    return CutErrors(("dome",) * n, tuple(map(str, range(n))), angle, error_um / 1000, np.full(n, 3e-4))


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


def found(parts: list[MadePart]) -> EdgeKnowledge:
    result = learnt(parts, ANGLES)
    assert result is not None
    return result


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


def test_in_all_is_what_is_predicted_of_a_next_part_of_the_type() -> None:
    """Without its touches, at the places of the last part of the type."""
    parts = history()
    asked = replace(_without_cuts(parts[-1]), serial="9")
    predicted = predict(parts, asked, parts[-1].semifinish).mean_mm
    at = learnt(parts, parts[-1].semifinish.contact_angle_rad)
    assert at is not None
    np.testing.assert_allclose(predicted, at.in_all["B"].mean_mm, atol=1e-9)
    own = np.array([name == "B" for name in at.behind.part_type])
    along = learnt(parts, at.behind.contact_angle_rad[own])
    assert along is not None
    np.testing.assert_allclose(along.in_all["B"].mean_mm, at.in_all_at_mm[own], atol=1e-9)
    assert np.max(at.in_all["B"].u_mm) < np.min(at.form.u_mm)


def _without_cuts(part: MadePart) -> MadePart:
    return replace(part, semifinish=CutErrors.none(), finish=None, correction_mm=None)


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
    part = replace(history()[0], semifinish=CutErrors.none(), finish=None, correction_mm=None)
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
