"""A refined model as values: what is left before and after, µm and µrad, places without a position, who accepted it."""

import pytest

from tests.support.worn_lathe import cut, lathe_model, yaw
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Acceptance, Version
from trueloop.machine.refine.refine import refine
from trueloop.report.diagnosis.machine_shapes import refinement_shape


def test_a_refinement_as_values() -> None:
    """The carriage turns by 100 µrad over 300 mm of its way, of which the model knows nothing."""
    model, guilty = lathe_model(), error_name("EBZ")
    found = refine(model, cut(model, yaw, 1), [guilty])
    version = Version(1, "3f2a", ("EBZ",), found.reason, str(found.judged.words), "2026-11-23T12:00:00Z")
    shape = refinement_shape(found, version)
    assert shape.accepted is None and shape.better and shape.parts == 12 and shape.errors == ["EBZ"]
    assert [left.of for left in shape.left_out] == ["parts", "part types"]
    for left in shape.left_out:
        assert left.before_um - left.after_um == pytest.approx(left.better_um, abs=1e-3) and left.better_um > 1.0
    turned = {change.at: change for change in shape.changes if change.error == "EBZ"}
    first, last = turned[min(turned, key=lambda at: at or 0.0)], turned[max(turned, key=lambda at: at or 0.0)]
    assert first.unit == "µrad" and first.at is not None and last.at is not None
    slope = (last.new - first.new) / (last.at - first.at)
    assert slope == pytest.approx(100.0 / 300.0, abs=0.05)
    accepted = Version(1, "3f2a", ("EBZ",), "", "", "", "", Acceptance("A. Turner", "2026-11-24T07:00:00Z"))
    assert refinement_shape(found, accepted).accepted == "A. Turner 2026-11-24T07:00:00Z"
