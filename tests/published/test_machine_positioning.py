"""ISO 230-2 on a real test, 9 targets × 5 cycles each way: B, M, A are stated with the data, E and R are computed.

The report that came with the data gives other E and R (it is stated to be wrong there), so those are computed here
anew from the raw numbers with plain loops.
"""

import re
from pathlib import Path
from statistics import mean, stdev

import pytest

from trueloop.formats.measurements.positioning_data import read_positioning

pytestmark = pytest.mark.corpus


@pytest.fixture
def path(corpus: Path) -> Path:
    return corpus / "data/public/iso230/b02-x.dat"


def _raw(path: Path) -> tuple[list[list[float]], list[list[float]]]:
    text = path.read_text()
    target = {int(i): float(v) for i, v in re.findall(r"TGT_DATA\[(\d)\]=(\S+)", text)}

    def table(way: str) -> list[list[float]]:
        found = re.findall(rf"REF_DATA_{way}\[(\d),(\d)\]=(\S+)", text)
        return [[float(v) - target[i] for k, _, v in found if int(k) == i] for i in sorted(target)]

    return table("FWD"), table("BWD")


def test_stated_values(path: Path) -> None:
    result = read_positioning(path)
    assert round(result.reversal, 5) == 0.03358
    assert round(result.mean_range, 5) == 0.09365
    assert round(result.accuracy.both, 5) == 0.13527
    assert result.deviation_up.shape == result.deviation_down.shape == (9, 5)


def test_e_and_r_by_the_formulas(path: Path) -> None:
    up, down = _raw(path)
    result = read_positioning(path)
    means = [[mean(row) for row in way] for way in (up, down)]
    s = [[stdev(row) for row in way] for way in (up, down)]
    e = [max(way) - min(way) for way in means]
    assert result.systematic.up == pytest.approx(e[0], abs=1e-12)
    assert result.systematic.down == pytest.approx(e[1], abs=1e-12)
    assert result.systematic.both == pytest.approx(max(map(max, means)) - min(map(min, means)), abs=1e-12)
    r_up, r_down = (max(4 * value for value in way) for way in s)
    pairs = zip(*means, *s, strict=True)
    r = max(r_up, r_down, *(2 * a + 2 * b + abs(m - n) for m, n, a, b in pairs))
    assert result.repeatability.up == pytest.approx(r_up, abs=1e-12)
    assert result.repeatability.down == pytest.approx(r_down, abs=1e-12)
    assert result.repeatability.both == pytest.approx(r, abs=1e-12)
    a_up = max(m + 2 * k for m, k in zip(means[0], s[0], strict=True)) - min(
        m - 2 * k for m, k in zip(means[0], s[0], strict=True)
    )
    assert result.accuracy.up == pytest.approx(a_up, abs=1e-12)
