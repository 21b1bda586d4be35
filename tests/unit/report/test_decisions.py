"""Decisions in words: the signs they state."""

from dataclasses import replace

from tests.support.correction import example_correction
from trueloop.report.turned.touch_table import commanded_words


def test_what_was_commanded_has_its_sign() -> None:
    """Touches 10 µm prouder than what was fitted: the semi-finish program left that on."""
    made = example_correction("modbas2")
    touches = replace(made.touches, error_mm=made.model.vectors.error_mm + 0.010)
    assert "by up to +10.0 µm (point" in commanded_words(replace(made, touches=touches))
