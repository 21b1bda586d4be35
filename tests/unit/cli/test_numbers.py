"""Options that are numbers: nan and what lies outside their bounds is a fault of the command line."""

import pytest

from tests.support.cli import invoke


@pytest.mark.parametrize(
    ("command", "option"),
    [
        ("surface path nominal.step --radius-mm nan", "--radius-mm"),
        ("surface path nominal.step --radius-mm 0", "--radius-mm"),
        ("surface path nominal.step --radius-mm 3 --feed -5", "--feed"),
        ("surface path nominal.step --radius-mm 3 --scallop-um inf", "--scallop-um"),
        ("surface path nominal.step --radius-mm 3 --chord-um 0", "--chord-um"),
        ("machine drift log.csv --window-h -1", "--window-h"),
        ("machine drift log.csv --window-h nan", "--window-h"),
        ("part from-program finish.nc --nose-radius-mm -0.1", "--nose-radius-mm"),
        ("nc diff one.nc other.nc --tolerance-mm nan", "--tolerance-mm"),
    ],
)
def test_it_is_refused_before_any_file_is_read(command: str, option: str) -> None:
    result = invoke(*command.split())
    assert result.exit_code == 2
    assert option in result.output and "is not a finite number" in result.output


def test_nought_is_a_nose_without_a_radius() -> None:
    result = invoke("part", "from-program", "nowhere.nc", "--nose-radius-mm", "0")
    assert (result.exit_code, "NC-FILE" in result.output) == (3, True)
