"""The priors that docs/memory.md states are those of the code."""

import math
import re
from pathlib import Path

import pytest

from trueloop.estimate.catalogue import PRIORS
from trueloop.memory.edge.learnt import MemoryOptions

PAGE = (Path(__file__).parents[2] / "docs" / "memory.md").read_text(encoding="utf-8")
UNITS = {"µm": 1e-3, "°": math.radians(1.0), "µm/100 mm": 1e-5, "of it": 1.0, "of 1": 1.0}


def test_priors_are_those_of_the_code() -> None:
    stated = re.findall(r"^\| .+ \| ([\d.]+) (µm/100 mm|µm|°|of it|of 1) \| ([\d.]+) \|$", PAGE, re.MULTILINE)
    assert len(stated) == len(PRIORS)
    for (median, unit, log_sd), prior in zip(stated, PRIORS.values(), strict=True):
        assert UNITS[unit] * float(median) == pytest.approx(prior.median, rel=0.005)
        assert float(log_sd) == prior.log_sd


def test_limits_are_those_of_the_code() -> None:
    options = MemoryOptions()
    assert f"more than {math.degrees(options.unseen_rad):.0f}° from all" in PAGE
    assert f"{options.first_weight} of the\ncorrection is commanded" in PAGE
