"""`trueloop docs`: the manual is served to this machine alone, and nothing but the manual."""

import re
import signal
import subprocess
import sys
from http.client import HTTPConnection
from pathlib import Path

import pytest

from tests.support.cli import invoke
from tests.support.manual import served_manual
from trueloop.cli.terminal import ExitStatus
from trueloop.errors import Code
from trueloop.server import manual

START = """
import sys
from pathlib import Path
from trueloop.cli.main import app
from trueloop.server import manual
place = Path(sys.argv[1])
manual.folder = lambda: place
app(sys.argv[2:])
"""


@pytest.fixture
def site(tmp_path: Path) -> Path:
    folder = tmp_path / "manual"
    (folder / "files").mkdir(parents=True)
    (folder / "index.html").write_text("<h1>Manual</h1>", encoding="utf-8")
    (folder / "files" / "finish.nc").write_text("G1 X10", encoding="utf-8")
    (folder / "drawing.svg").write_text("<svg/>", encoding="utf-8")
    (tmp_path / "secret.txt").write_text("secret", encoding="utf-8")
    return folder


def asked(address: str, path: str) -> tuple[int, str, str, str]:
    """Status, type, policy and body; the path goes as it stands."""
    connection = HTTPConnection(address.split("/")[2], timeout=20)
    connection.request("GET", path)
    answer = connection.getresponse()
    found = (answer.status, answer.getheader("Content-Type", ""), answer.getheader("Content-Security-Policy", ""))
    body = answer.read().decode()
    connection.close()
    return *found, body


def test_files_are_served_as_what_they_are(site: Path) -> None:
    with served_manual(site) as address:
        status, kind, policy, body = asked(address, "/")
        assert (status, kind, body) == (200, "text/html; charset=utf-8", "<h1>Manual</h1>")
        assert "default-src 'none'; script-src 'self';" in policy and "unsafe" not in policy
        assert asked(address, "/files/finish.nc")[:2] == (200, "text/plain; charset=utf-8")
        assert "sandbox" in asked(address, "/drawing.svg?x")[2]


@pytest.mark.parametrize("path", ["/../secret.txt", "/..%2fsecret.txt", "/%2e%2e/secret.txt", "/files/", "/nothing"])
def test_nothing_else_is_served(site: Path, path: str) -> None:
    with served_manual(site) as address:
        assert asked(address, path)[0] == 404


def test_it_listens_to_this_machine_alone(site: Path) -> None:
    with manual.listening(site, 0) as server:
        assert server.server_address[0] == "127.0.0.1"


def test_a_port_that_is_taken_is_refused(site: Path) -> None:
    with manual.listening(site, 0) as server, pytest.raises(Exception, match=Code.SRV_ADDRESS):
        manual.listening(site, server.server_port)


def test_words_lead_to_the_search(site: Path) -> None:
    with manual.listening(site, 0) as server:
        assert manual.address(server, "wear offset & U").endswith("/search.html?q=wear%20offset%20%26%20U")


def test_a_manual_that_was_not_built_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(manual, "folder", lambda: tmp_path)
    refused = invoke("docs", "--no-browser", status=ExitStatus.REFUSED).stderr
    assert Code.SRV_MANUAL in refused and "make docs" in refused


def test_the_command_serves_until_it_is_interrupted(site: Path) -> None:
    command = [sys.executable, "-c", START, str(site), "docs", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        said = running.stdout.readline()
        address = re.search(r"http://127\.0\.0\.1:\d+/", said)
        assert address, said
        assert asked(address[0], "/index.html")[0] == 200
        running.send_signal(signal.SIGINT)
        assert running.wait(20) == ExitStatus.DONE
