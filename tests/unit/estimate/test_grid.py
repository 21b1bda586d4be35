"""Sizes on a grid and their weights, by hand."""

import numpy as np
import pytest

from trueloop.estimate.weights import probabilities, shares, tried


def test_weights_of_one_to_three_whatever_constant_their_logarithms_have() -> None:
    log = np.array([[0.0, np.log(3.0)], [-2000.0, -2000.0]])
    assert probabilities(log) == pytest.approx(np.array([[0.25, 0.75], [0.5, 0.5]]))
    assert probabilities(log, axis=None)[0] == pytest.approx([0.25, 0.75])
    assert shares({"less": 800.0, "more": 800.0 + np.log(3.0)}) == {
        "more": pytest.approx(0.75),
        "less": pytest.approx(0.25),
    }
    assert next(iter(shares({"less": 800.0, "more": 801.0}))) == "more"


def test_every_combination_of_sizes_as_those_of_the_columns() -> None:
    """Two columns of the first block, one of the second; no block has one combination without a size."""
    assert tried([(1.0, 2.0), (3.0, 5.0)], np.array([0, 0, 1])).tolist() == [[1, 1, 3], [1, 1, 5], [2, 2, 3], [2, 2, 5]]
    assert tried([], np.array([], dtype=np.intp)).shape == (1, 0)
