"""The priors that docs/memory.md states are those of the code."""

import math
import re
from pathlib import Path

from trueloop.memory.edge.hyperparameters import PRIORS
from trueloop.memory.edge.options import MemoryOptions

PAGE = (Path(__file__).parents[2] / "docs" / "memory.md").read_text(encoding="utf-8")


def test_priors_are_those_of_the_code() -> None:
    stated = re.findall(r"^\| .+ \| ([\d.]+) ?(µm|°) \| ([\d.]+) \|$", PAGE, re.MULTILINE)
    as_coded = {
        (round(math.degrees(one.median), 6) if one.name.endswith("_rad") else round(1000 * one.median, 6), one.log_sd)
        for one in PRIORS
    }
    assert {(float(median), float(log_sd)) for median, _, log_sd in stated} == as_coded
    assert len(stated) == len(PRIORS) - 1  # both angles stand in one row


def test_limits_are_those_of_the_code() -> None:
    options = MemoryOptions()
    assert f"more than {math.degrees(options.unseen_rad):.0f}° from all" in PAGE
    assert f"{options.first_weight} of the\ncorrection is commanded" in PAGE
