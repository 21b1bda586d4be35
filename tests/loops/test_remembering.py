"""Earlier parts of an edge inside a correction: parts in a row on the simulated lathe, whose truth is no model's."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from tests.support.correction import example_inputs
from tests.support.edge_in_simulator import CutPart, cut, rms_um, workshop_of
from trueloop.arrays import Array
from trueloop.domain.record import Correction as Envelope
from trueloop.errors import TrueloopError
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.made_parts import points_to_keep
from trueloop.loops.turned.provenance import CODEC, enveloped
from trueloop.memory.edge.learnt import IN_FULL
from trueloop.memory.made_part import CutErrors, MadePart
from trueloop_lab.loops.turned import Trial, trial_of

PARTS = 5
FEW = (2, 9, 16)
"""The 3rd, 10th and 17th of the dome's twenty touches."""


@cache
def trial() -> Trial:
    inputs = example_inputs("modbas2")
    return trial_of(inputs, inputs.touches.point[int(np.flatnonzero(inputs.touches.at_reference)[0])])


def dome() -> int:
    return trial().inputs.profile.names.index("dome")


@cache
def row() -> tuple[CutPart, ...]:
    """Five parts of one edge: the first with twenty touches of its dome, the others with three."""
    made: list[CutPart] = []
    for k in range(PARTS):
        history = tuple(part.made for part in made)
        made.append(cut(trial(), dome(), None if k == 0 else FEW, history, workshop_of(k), k))
    return tuple(made)


def next_part(**more: Any) -> CutPart:
    """The part after those, with three touches; `more` are other inputs."""
    history = tuple(part.made for part in row())
    return cut(trial(), dome(), FEW, history, workshop_of(PARTS), PARTS, **more)


@cache
def by_memory() -> Correction:
    return next_part().correction


def left(parts: tuple[CutPart, ...]) -> Array:
    return np.concatenate([part.left_mm for part in parts])


def test_three_touches_and_earlier_parts_leave_less_than_half_of_what_three_touches_leave() -> None:
    """And no more than all twenty do without earlier parts: the finish cut does otherwise than the touched one."""
    few = tuple(cut(trial(), dome(), FEW, (), workshop_of(k), k) for k in range(1, PARTS))
    every = tuple(cut(trial(), dome(), None, (), workshop_of(k), k) for k in range(1, PARTS))
    remembered = rms_um(left(row()[1:]))
    assert remembered < 0.5 * rms_um(left(few))
    assert remembered < rms_um(left(every))


def test_the_bands_hold_what_is_left() -> None:
    parts = row()[1:]
    expected, u = (np.concatenate([getattr(part, name) for part in parts]) for name in ("expected_mm", "expanded_u_mm"))
    inside = np.mean(np.abs(left(parts) - expected) <= u)
    assert 0.9 <= inside <= 1.0
    assert np.max(u) < 0.010
    assert np.max(row()[-1].expanded_u_mm) < np.max(row()[1].expanded_u_mm)


def test_the_first_part_is_as_without_a_store() -> None:
    first, again = row()[0].correction, cut(trial(), dome(), None, (), workshop_of(0), 0, memory=IN_FULL).correction
    assert first.memory is None
    assert first.corrected_program == again.corrected_program
    assert "memory" not in first.record.options


def test_switched_off_it_is_as_without_earlier_parts() -> None:
    off = next_part(memory=replace(IN_FULL, memory="off")).correction
    own = cut(trial(), dome(), FEW, (), workshop_of(PARTS), PARTS).correction
    assert off == own
    assert off.record.id != by_memory().record.id


def test_bands_alone_change_no_program_and_say_what_it_leaves() -> None:
    part = next_part(memory=replace(IN_FULL, memory="bands"))
    own = cut(trial(), dome(), FEW, (), workshop_of(PARTS), PARTS)
    by_hand = part.correction.corrected_program.splitlines()[5:]
    assert [line for line in by_hand if b"RECORD" not in line.upper()] == [
        line for line in own.correction.corrected_program.splitlines()[5:] if b"RECORD" not in line.upper()
    ]
    assert np.max(part.expanded_u_mm) < 0.5 * np.max(own.expanded_u_mm)
    assert rms_um(part.left_mm - part.expected_mm) < 0.6 * rms_um(part.left_mm)


def test_what_came_from_memory_is_said_and_kept() -> None:
    correction = by_memory()
    memory = correction.memory
    assert memory is not None and memory.applied and memory.expected is not None
    assert memory.expected.parts == PARTS
    touched = correction.touches
    assert memory.points == tuple(np.array(touched.point)[~touched.at_reference].tolist())
    assert memory.features == tuple(range(len(correction.profile.features)))
    words = " ".join(memory.words(correction.profile))
    assert "Memory of edge SVJBL VCMT 110304 1, inspected parts: 5." in words
    assert f"dome: {100 * memory.share(dome()):.0f} % of the correction is from memory" in words
    assert set(memory.words(correction.profile)) <= set(correction.notes)
    stated = correction.record.model["memory"]
    assert isinstance(stated, dict) and stated["mean_mm"] == memory.expected.mean_mm.tolist()
    assert CODEC.from_json(CODEC.to_json(enveloped(correction)), Envelope) == enveloped(correction)


def test_the_share_from_memory_is_that_of_the_correction_that_was_cut() -> None:
    """Most of it, by three touches: what a part shows later is judged against both."""
    made = row()[-1].made
    assert made.correction_mm is not None and made.from_memory_mm is not None
    assert made.from_memory_mm == pytest.approx(made.correction_mm, abs=0.008)
    assert np.max(np.abs(made.from_memory_mm)) > 0.02
    first = row()[0].made.from_memory_mm
    assert first is not None and not np.any(first)


def test_touches_that_contradict_earlier_parts_correct_alone() -> None:
    """The edge was set anew, 80 µm off, and nobody said so."""
    history = tuple(part.made for part in row())
    moved = cut(trial(), dome(), FEW, history, workshop_of(PARTS, moved_mm=0.080), PARTS).correction
    own = cut(trial(), dome(), FEW, (), workshop_of(PARTS, moved_mm=0.080), PARTS).correction
    assert moved.memory is not None and moved.memory.alarms and not moved.memory.applied
    assert moved.model == own.model
    assert any("contradict earlier parts" in note for note in moved.notes)


def without_angles_below(part: MadePart, least_rad: float) -> MadePart:
    def above(errors: CutErrors) -> CutErrors:
        return errors.chosen(np.flatnonzero(errors.contact_angle_rad > least_rad))

    assert part.finish is not None and part.correction_mm is not None
    kept = part.finish.contact_angle_rad > least_rad
    return replace(
        part, semifinish=above(part.semifinish), finish=above(part.finish), correction_mm=part.correction_mm[kept]
    )


def test_angles_that_nobody_has_seen_are_refused_with_a_few_touches_and_left_to_many() -> None:
    history = tuple(without_angles_below(part.made, np.radians(60.0)) for part in row())
    touches = (0, 1, 2)
    with pytest.raises(TrueloopError, match="MEM-UNSEEN"):
        cut(trial(), dome(), touches, history, workshop_of(PARTS), PARTS)
    every = cut(trial(), dome(), (0, 4, 8, 12, 16, 19), history, workshop_of(PARTS), PARTS).correction
    assert every.memory is not None and dome() not in every.memory.features
    assert any("have not shown" in note for note in every.notes)


def test_the_points_to_keep_are_spread_over_the_part() -> None:
    """Of twenty the 3rd, 10th and 17th [memory of NIST's parts]; never fewer than three, which judge a part as well."""
    angle = np.linspace(1.5, 0.0, 20)
    names = tuple(str(k + 1) for k in range(20))
    touches = CutErrors(("dome",) * 20, names, angle, np.zeros(20), np.zeros(20))
    assert points_to_keep(touches, 3) == ("3", "10", "17")
    assert points_to_keep(touches, 1) == ("3", "10", "17")
    assert len(points_to_keep(touches, 7)) == 7
    assert points_to_keep(CutErrors.none(), 3) == ()
