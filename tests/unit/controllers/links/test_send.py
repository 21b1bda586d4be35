"""A program sent to a control: whatever breaks, the control holds the old program or the new one, whole."""

import ftplib
import os
import subprocess
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from tests.support.ftp_server import PASSWORD, USER, ftp_server
from tests.support.refusals import refused
from trueloop.controllers.links.compare import Change
from trueloop.controllers.links.folder import Folder, Link, named_in, not_reached
from trueloop.controllers.links.ftp import Ftp
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.links import Opened, send

OLD, NEW = b"O1 (OLD)\nG1 X10.\nM30\n", b"O1 (NEW)\nG1 X9.9592\nM30\n"
replacing = partial(send, replace=True, not_running=True)


def link_to(link: Link, folder: Path, *passes: Change) -> Opened:
    return Opened("lathe", link, frozenset(passes), folder / "replaced")


@pytest.fixture
def control(tmp_path: Path) -> Path:
    folder = tmp_path / "control"
    folder.mkdir()
    (folder / "O1.nc").write_bytes(OLD)
    return folder


def names(folder: Path) -> list[str]:
    return sorted(one.name for one in folder.iterdir())


@dataclass
class Broken:
    """A link that breaks at its k-th call, before it or after it was carried out."""

    link: Link
    at: int
    after: bool
    calls: list[str] = field(default_factory=list)

    def __getattr__(self, name: str) -> Any:
        whole = getattr(self.link, name)
        return self._counted(name, whole) if callable(whole) else whole

    def _counted(self, name: str, whole: Callable[..., Any]) -> Callable[..., Any]:
        def call(*arguments: object) -> Any:
            self.calls.append(name)
            breaks = len(self.calls) == self.at
            if breaks and not self.after:
                raise not_reached("the line", "cut")
            answer = whole(*arguments)
            if breaks:
                raise not_reached("the line", "cut")
            return answer

        return call


@pytest.mark.parametrize("after", [False, True])
@pytest.mark.parametrize("at", range(1, 20))
def test_a_link_that_breaks_anywhere_leaves_a_whole_program(
    control: Path, tmp_path: Path, at: int, after: bool
) -> None:
    broken = Broken(Folder(control), at, after)
    try:
        done = replacing(link_to(broken, tmp_path), NEW, "O1.nc")
    except TrueloopError as error:
        assert error.code is Code.LNK_REACH
        assert (control / "O1.nc").read_bytes() in (OLD, NEW)
    else:
        assert len(broken.calls) < at
        assert done.written and (control / "O1.nc").read_bytes() == NEW
    if (control / "O1.nc").read_bytes() == NEW:
        assert [one.read_bytes() for one in (tmp_path / "replaced" / "lathe").iterdir()] == [OLD]
    again = replacing(link_to(Folder(control), tmp_path), NEW, "O1.nc")
    assert again.read_back_sha256 == again.sent_sha256
    assert names(control) == ["O1.nc"]


def test_another_program_is_replaced_only_when_asked_and_idle(control: Path, tmp_path: Path) -> None:
    running = tmp_path / "running.txt"
    opened = link_to(Folder(control, named_in(running)), tmp_path)
    running.write_text("\n")
    assert refused(send, opened, NEW, "O1.nc").code is Code.LNK_EXISTS
    running.write_text("C:\\NC\\o1.NC\nline 12\n")
    assert refused(replacing, opened, NEW, "O1.nc").code is Code.LNK_RUNNING
    running.unlink()
    assert refused(partial(send, replace=True), opened, NEW, "O1.nc").code is Code.LNK_RUNNING
    assert (control / "O1.nc").read_bytes() == OLD and names(control) == ["O1.nc"]
    assert not (tmp_path / "replaced").exists()
    running.write_text("O2.nc\n")
    assert send(opened, NEW, "O1.nc", replace=True).kept is not None


def test_what_is_there_already_is_not_sent(control: Path, tmp_path: Path) -> None:
    done = send(link_to(Folder(control), tmp_path, Change.LINE_ENDS), OLD.replace(b"\n", b"\r\n"), "O1.nc")
    assert not done.written and (control / "O1.nc").read_bytes() == OLD


def test_a_program_changed_at_the_control_meanwhile_is_not_replaced(control: Path, tmp_path: Path) -> None:
    edited = OLD + b"(AT THE CONTROL)\n"

    class Edited(Folder):
        def write_aside(self, name: str, content: bytes) -> str:
            (self.folder / name).write_bytes(edited)
            return super().write_aside(name, content)

    assert refused(replacing, link_to(Edited(control), tmp_path), NEW, "O1.nc").code is Code.LNK_CHANGED
    assert (control / "O1.nc").read_bytes() == edited and names(control) == ["O1.nc"]


@pytest.mark.parametrize("name", ["../O1.nc", "a/b", "a\\b", "", ".hidden", "a\x00b", "O1.part", "x" * 101, "a..b"])
def test_no_name_leaves_the_folder(control: Path, tmp_path: Path, name: str) -> None:
    assert refused(send, link_to(Folder(control), tmp_path), NEW, name).code is Code.LNK_NAME
    assert names(control) == ["O1.nc"]


def test_names_that_differ_in_capitals_are_one_program_to_many_controls(control: Path, tmp_path: Path) -> None:
    assert refused(replacing, link_to(Folder(control), tmp_path), NEW, "o1.NC").code is Code.LNK_EXISTS


def test_links_of_the_file_system_are_not_followed(control: Path, tmp_path: Path) -> None:
    (tmp_path / "secret").write_bytes(b"x")
    (control / "O2.nc").symlink_to(tmp_path / "secret")
    assert [one.name for one in Folder(control).listed()] == ["O1.nc"]
    assert refused(Folder(control).read, "O2.nc").code is Code.LNK_NAME


@pytest.fixture
def password(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LATHE_PASSWORD", PASSWORD)


def ftp(port: int) -> Ftp:
    return Ftp("127.0.0.1", port, USER, "LATHE_PASSWORD", timeout_s=20)


@pytest.mark.usefixtures("password")
@pytest.mark.parametrize("ways", [(), ("no-replacing",)])
def test_by_ftp_a_program_is_replaced_and_what_was_there_kept(
    control: Path, tmp_path: Path, ways: tuple[str, ...]
) -> None:
    with ftp_server(control, *ways) as port:
        link = ftp(port)
        assert [(one.name, one.size_bytes) for one in link.listed()] == [("O1.nc", len(OLD))]
        done = replacing(link_to(link, tmp_path), NEW, "O1.nc")
        assert done.kept is not None and done.kept.read_bytes() == OLD
        assert names(control) == ["O1.nc"] and (control / "O1.nc").read_bytes() == NEW
        assert send(link_to(link, tmp_path), OLD, "O2.nc").kept is None
        assert refused(link.read, "O3.nc").code is Code.LNK_NAME


@pytest.mark.usefixtures("password")
def test_a_server_that_changes_programs_is_found_out(control: Path, tmp_path: Path) -> None:
    small = NEW.lower()
    with ftp_server(control, "capitals") as port:
        error = refused(replacing, link_to(ftp(port), tmp_path), small, "O1.nc")
        assert error.code is Code.LNK_DIFFERS and error.values["lines"] == [1, 2, 3]
        assert names(control) == ["O1.nc"] and (control / "O1.nc").read_bytes() == OLD
        assert replacing(link_to(ftp(port), tmp_path, Change.CAPITALS), small, "O1.nc").written


@pytest.mark.usefixtures("password")
def test_a_connection_cut_in_the_transfer_changes_no_program(control: Path, tmp_path: Path) -> None:
    large = b"".join(b"X%d\n" % k for k in range(500_000))
    with ftp_server(control, "cut=100000") as port:
        assert refused(replacing, link_to(ftp(port), tmp_path), large, "O1.nc").code is Code.LNK_REACH
    assert (control / "O1.nc").read_bytes() == OLD
    assert names(control) == ["O1.nc", "O1.nc.part"]
    with ftp_server(control) as port:
        assert [one.name for one in ftp(port).listed()] == ["O1.nc"]
        assert replacing(link_to(ftp(port), tmp_path), large, "O1.nc").written
    assert names(control) == ["O1.nc"]


@pytest.mark.usefixtures("password")
def test_an_exchange_cut_between_its_renames_is_mended(control: Path) -> None:
    (control / "O1.nc").rename(control / "O1.nc.old.part")
    with ftp_server(control) as port:
        assert [one.name for one in ftp(port).listed()] == ["O1.nc"]
    assert (control / "O1.nc").read_bytes() == OLD


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`good.pem` of 127.0.0.1 and `other.pem` of another name, each with its key and its own authority."""
    folder = tmp_path_factory.mktemp("certificates")
    for name, host in (("good", "IP:127.0.0.1"), ("other", "DNS:another.example")):
        key = ("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={name}")
        files = ("-keyout", folder / "key.pem", "-out", folder / "cert.pem")
        subprocess.run([*key, "-addext", f"subjectAltName={host}", *files], check=True, capture_output=True)
        both = (folder / "key.pem").read_bytes() + (folder / "cert.pem").read_bytes()
        (folder / f"{name}.pem").write_bytes(both)
    return folder


def ftps(port: int, authority: Path | None) -> Ftp:
    return replace(ftp(port), tls=True, authority=authority)


@pytest.mark.usefixtures("password")
def test_over_tls_a_program_is_replaced_and_read_back(control: Path, tmp_path: Path, certificates: Path) -> None:
    good = certificates / "good.pem"
    with ftp_server(control, f"tls={good}") as port:
        assert refused(ftp(port).listed).code is Code.LNK_REACH  # the server takes no password in the clear
        link = ftps(port, good)
        done = replacing(link_to(link, tmp_path), NEW, "O1.nc")
        assert not link.note and done.kept is not None and done.kept.read_bytes() == OLD
        assert [one.name for one in link.listed()] == ["O1.nc"] and link.read("O1.nc") == NEW


@pytest.mark.parametrize(("shown", "trusted"), [("good", None), ("good", "other"), ("other", "other")])
def test_a_server_whose_certificate_is_not_the_one_gets_no_password(
    control: Path, certificates: Path, monkeypatch: pytest.MonkeyPatch, shown: str, trusted: str | None
) -> None:
    told = list[str]()
    monkeypatch.setattr(ftplib.FTP, "login", lambda *_: told.append("password"))
    with ftp_server(control, f"tls={certificates / shown}.pem") as port:
        link = ftps(port, None if trusted is None else certificates / f"{trusted}.pem")
        assert refused(link.listed).code is Code.LNK_REACH
    assert told == []


def test_a_wrong_password_is_refused_and_not_printed(control: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LATHE_PASSWORD", "other-word")
    with ftp_server(control) as port:
        error = refused(ftp(port).listed)
    assert error.code is Code.LNK_REACH and "530" in error.message and "other-word" not in str(error)
    assert os.environ["LATHE_PASSWORD"] not in error.hint
