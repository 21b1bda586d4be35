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


@pytest.mark.parametrize(
    "command",
    [
        "new finish.nc --nose-radius-mm 0,4",
        "surface path a.step --radius-mm=0,4",
        "machine drift log.csv --window-h 0,4",
    ],
)
def test_a_decimal_comma_is_refused_with_the_number_to_write(command: str) -> None:
    result = invoke(*command.split())
    assert result.exit_code == 2 and "0,4 has a decimal comma: write 0.4" in result.output


def test_a_word_in_the_place_of_a_number_has_no_decimal_comma() -> None:
    result = invoke("surface", "path", "a,b.step", "--radius-mm", "0,4,5")
    assert result.exit_code == 2 and "decimal comma" not in result.output


def test_nought_is_a_nose_without_a_radius() -> None:
    result = invoke("part", "from-program", "nowhere.nc", "--nose-radius-mm", "0")
    assert (result.exit_code, "NC-FILE" in result.output) == (3, True)
