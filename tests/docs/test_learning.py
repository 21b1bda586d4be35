"""The example of docs/learning.md is what the simulator gives."""

import numpy as np
import pytest

from tests.support.edge_example import FOLDER, files, text_of


def test_the_example_is_what_the_simulator_gives() -> None:
    """To a digit of what is written: sums in another order round otherwise."""
    for name, vectors in files().items():
        written = (FOLDER / name).read_text(encoding="utf-8")
        rows = [text.splitlines()[2:] for text in (written, text_of(vectors))]
        there, made = (np.array([float(row.rpartition(",")[2]) for row in of]) for of in rows)
        assert there == pytest.approx(made, abs=0.11)
        assert [row.rpartition(",")[0] for row in rows[0]] == [row.rpartition(",")[0] for row in rows[1]]
