"""The benchmark's arithmetic, on times that are given, not measured."""

from pathlib import Path

import pytest

from benches import ratio
from benches.ratio import Contender, Samples, compare, process
from scripts import performance_page


def test_a_ratio_compares_times_of_the_same_round() -> None:
    """The rounds give 2, 20 and 2; the medians alone, 20 and 1, would give 20."""
    samples = Samples({"ours": [1.0, 1.0, 10.0], "rival": [2.0, 20.0, 20.0]})
    assert samples.ratio("rival", to="ours") == 2.0
    assert samples.median_s("rival") == 20.0


def test_contenders_run_in_turn_and_the_table_has_a_row_each(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ratio, "SAMPLE_S", 1e-4)
    calls: list[str] = []
    contenders = [Contender("ours", lambda: calls.append("o")), Contender("rival", lambda: calls.append("r"), "1e-9")]
    samples = compare("a title", contenders, rounds=3, note_heading="error")
    assert len(samples.seconds["ours"]) == len(samples.seconds["rival"]) == 3
    turns = [call for call, before in zip(calls, ["", *calls], strict=False) if call != before]
    assert turns == ["o", "r"] * 4
    table = capsys.readouterr().out
    assert table.count("| ours |") == table.count("| rival |") == 1
    assert "1e-9" in table


def test_ratios_are_kept_by_version_and_a_later_one_that_fell_is_named(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(ratio, "KEPT", tmp_path / "kept.csv")
    now = "1.0"
    monkeypatch.setattr(ratio, "version", lambda _: now)
    ratio.keep("spline", "ours", {"scipy": 9.0, "numpy": 2.0})
    ratio.keep("spline", "ours", {"scipy": 10.0, "numpy": 2.0})  # a second run takes the first one's place
    now = "2.0"
    ratio.keep("spline", "ours", {"scipy": 4.0, "numpy": 1.9})
    assert [(one.version, one.rival, one.ratio) for one in ratio.kept()] == [
        *(("1.0", "scipy", 10.0), ("1.0", "numpy", 2.0)),
        *(("2.0", "scipy", 4.0), ("2.0", "numpy", 1.9)),
    ]
    assert "| scipy | 10 × | 4 × |" in performance_page.page()
    ratio.print_slower("spline", {"scipy": 4.0, "numpy": 1.9})
    assert capsys.readouterr().out == "\nSLOWER beside scipy: 4 ×, 10 × at version 1.0\n"


def test_a_process_that_fails_ends_the_benchmark_with_what_it_said() -> None:
    with pytest.raises(SystemExit, match="no-such-file"):
        process("ls", "no-such-file")()
