"""The browser helper sees what scripts did and what the console said."""

import struct
from pathlib import Path

import pytest

from tests.support.chromium import ChromiumMissingError, console_errors, dump_dom, screenshot

QUIET = "<!doctype html><title>t</title><body><p id=p></p><script>p.textContent = 'made by ' + 'a script'</script>"


@pytest.fixture
def page(tmp_path: Path) -> Path:
    file = tmp_path / "a page.html"
    file.write_text(QUIET)
    return file


def test_the_dom_is_that_after_the_scripts(page: Path) -> None:
    assert "made by a script</p>" in dump_dom(page)


def test_a_screenshot_has_the_asked_size(page: Path, tmp_path: Path) -> None:
    png = tmp_path / "shot.png"
    screenshot(page, png, 640, 480)
    assert struct.unpack(">II", png.read_bytes()[16:24]) == (640, 480)


def test_a_quiet_page_has_no_console_messages(page: Path) -> None:
    assert console_errors(page) == []


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("<script>nobody()</script>", "nobody is not defined"),
        ("<script>console.error('with \"quotes\"')</script>", 'with "quotes"'),
        ("<script>console.warn('first\\\\nsecond')</script>", "first\\nsecond"),
    ],
)
def test_faults_are_heard(page: Path, fault: str, said: str) -> None:
    page.write_text(QUIET + fault)
    assert any(said in message for message in console_errors(page))


def test_without_chromium_the_failure_says_what_to_install(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nonexistent")
    with pytest.raises(ChromiumMissingError, match="apt-get install -y --no-install-recommends chromium"):
        dump_dom(page)
