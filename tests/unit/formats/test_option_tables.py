"""A table's keys are the options of a dataclass: its defaults in the key's unit, its bounds, and back in mm."""

from dataclasses import dataclass
from typing import Annotated

import pytest
from pydantic import ValidationError

from trueloop.domain.option import Limits, MapOptions, Option, choices_of, inside
from trueloop.formats.toml_tables import Table, options_from, with_options
from trueloop.probing.probe_plan import Approach
from trueloop.surface.options import SurfaceOptions
from trueloop.turned.options import Options
from trueloop.turned.touches.touches import Gauging


@dataclass(frozen=True)
class Feeler:
    size_mm: Annotated[float, Option("probe.size_um", "How large it is.", above=0)] = 0.002
    lean_rad: Annotated[float | None, Option("probe.lean_deg", "How it leans.", most=90)] = None
    share: Annotated[float, Option("probe.share_percent", "How much of it.", least=0, below=100)] = 0.25
    cells: Annotated[tuple[int, int] | None, Option("probe.cells", "How many.", least=2)] = None
    elsewhere: Annotated[float, Option("other.elsewhere", "Not of this table.")] = 1.0
    name: str = "A"


@with_options("probe", Feeler)
class ProbeTable(Table):
    """A probe."""

    file: str


class File(Table):
    probe: ProbeTable


def feeler(**given: object) -> dict[str, object]:
    table = ProbeTable.model_validate({"file": "a", **given})
    return {key: getattr(table, key) for key in ("size_um", "lean_deg", "share_percent", "cells")}


def test_defaults_are_those_of_the_dataclass_in_the_unit_of_the_key() -> None:
    assert feeler() == {"size_um": 2.0, "lean_deg": None, "share_percent": 25.0, "cells": None}
    assert list(ProbeTable.model_fields) == ["size_um", "lean_deg", "share_percent", "cells", "file"]


@pytest.mark.parametrize(
    "wrong",
    [
        {"size_um": 0},
        {"size_um": "2"},
        {"size_um": float("nan")},
        {"size_um": 1e16},
        {"lean_deg": 90.5},
        {"share_percent": 100},
        {"share_percent": -1},
        {"cells": [1, 2]},
        {"cells": [2.5, 2]},
        {"elsewhere": 1.0},
    ],
)
def test_what_is_out_of_bounds_or_of_another_table_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        feeler(**wrong)


def test_values_arrive_in_millimetres_radians_and_shares() -> None:
    probe = {"file": "a", "size_um": 500, "lean_deg": 90, "share_percent": 5, "cells": [3, 4]}

    @dataclass(frozen=True)
    class Both:
        size_mm: Annotated[float, Option("probe.size_um", "")] = 0.0
        lean_rad: Annotated[float | None, Option("probe.lean_deg", "")] = None
        share: Annotated[float, Option("probe.share_percent", "")] = 0.0
        name: str = "A"

    read = options_from(Both, File.model_validate({"probe": probe}), name="B")
    assert (read.size_mm, read.share, read.name) == (0.5, 0.05, "B")
    assert read.lean_rad == pytest.approx(1.5707963267948966, abs=1e-15)


@pytest.mark.parametrize("kind", [Limits, MapOptions, Options, Gauging, SurfaceOptions, Approach])
def test_no_default_changes_by_being_written_in_the_unit_of_its_key(kind: type) -> None:
    choices = choices_of(kind)
    assert choices
    assert {name: inside(c.option.key, c.default) for name, c in choices.items()} == {
        name: getattr(kind(), name) for name in choices
    }
