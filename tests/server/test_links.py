"""Links to controls over HTTP: of the settings that the service was told of, with the last transfer of each."""

from datetime import datetime
from pathlib import Path

import pytest

from tests.support.cli import invoke, output_of
from tests.support.factory import OPERATOR, SHA
from tests.support.full_shop import full_shop
from tests.support.service import Running, problem, started
from trueloop.factory import requests as ask
from trueloop.server.settings import Settings
from trueloop.storage.store import Store

SECRET = "5ecret"
LINKS = """[folder.lathe]
folder = "/mnt/lathe/programs"
[ftp.mill]
host = "192.168.0.20"
user = "op"
password_env = "MILL_PASSWORD"
folder = "nc"
[serial.old]
port = "/dev/ttyUSB0"
[linuxcnc.router]
ini = "router.ini"
folder = "nc_files"
[focas.turn]
host = "192.168.0.30"
library = "libfwlib32.so"
aside = 9001
"""


@pytest.fixture
def links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MILL_PASSWORD", SECRET)
    (tmp_path / "links.toml").write_text(LINKS, encoding="utf-8")
    return tmp_path / "links.toml"


@pytest.fixture
def told(store: Store, links: Path) -> Running:
    """A service that was told of the settings, on a shop with transfers to one of these controls and to another."""
    shop = full_shop(store)
    for control, outcome in (("mill", "read back"), ("mill", "LNK-DIFFERS: 'O2' came back"), ("gone", "fetched")):
        shop.do(ask.RecordTransfer(control, SHA["finish"], "O2", "to", SHA["finish"], "", outcome), OPERATOR)
    return started(store, Settings(workers=0, links=links))


def test_each_link_has_its_kind_address_and_last_transfer(told: Running, links: Path) -> None:
    shown = told.signed_in("engineer").get("links").json()
    assert shown["settings"] is True
    assert [(one["control"], one["kind"], one["where"], one["machine"]) for one in shown["items"]] == [
        ("gone", "", "", False),
        ("lathe", "folder", "/mnt/lathe/programs", True),
        ("mill", "ftp", "ftp://op@192.168.0.20:21/nc", True),
        ("old", "serial", "/dev/ttyUSB0", False),
        ("router", "linuxcnc", str(links.parent / "nc_files"), False),
        ("turn", "focas", "focas://192.168.0.30:8193", False),
    ]
    last = {one["control"]: one["last"] for one in shown["items"]}
    assert {name: one and one["outcome"] for name, one in last.items()} == {
        **{"gone": "fetched", "lathe": "sent", "mill": "LNK-DIFFERS: 'O2' came back"},
        **{"old": None, "router": None, "turn": None},
    }
    assert (last["mill"]["program"], last["mill"]["direction"], last["mill"]["who"]) == ("O2", "to", OPERATOR.name)
    assert datetime.fromisoformat(last["mill"]["at"]).tzinfo is not None


def test_no_password_is_in_the_answer(told: Running) -> None:
    answer = told.signed_in("admin").get("links").text
    assert SECRET not in answer and "MILL_PASSWORD" not in answer


def test_without_settings_the_controls_of_the_store_are_listed_and_nothing_is_made_up(service: Running) -> None:
    full_shop(service.store)
    shown = service.signed_in("engineer").get("links").json()
    assert shown["settings"] is False
    assert [(one["control"], one["kind"], one["where"]) for one in shown["items"]] == [("lathe", "", "")]


@pytest.mark.parametrize("role", ["viewer", "operator"])
def test_addresses_of_controls_are_for_engineers(told: Running, role: str) -> None:
    assert problem(told.signed_in(role).get("links")) == "SRV-ROLE"


def test_settings_are_read_when_asked_for_and_refused_by_their_line(told: Running, links: Path) -> None:
    ana = told.signed_in("engineer")
    links.write_text('[folder.lathe]\nfolder = "elsewhere"\n', encoding="utf-8")
    lathe = next(one for one in ana.get("links").json()["items"] if one["control"] == "lathe")
    assert lathe["where"] == str(links.parent / "elsewhere")
    links.write_text('[folder.lathe]\nfolder = "nc"\npases = []\n', encoding="utf-8")
    assert problem(ana.get("links")) == "LNK-FILE"
    links.unlink()
    assert problem(ana.get("links")) == "LNK-FILE"


def test_a_service_is_not_started_on_settings_that_are_wrong(links: Path) -> None:
    links.write_text('[folder.lathe]\nfolder = "nc"\npases = []\n', encoding="utf-8")
    database = links.parent / "trueloop.db"
    output_of("db", "init", database)
    said = invoke("serve", "--links", links, "--db", database, "--port", 0)
    assert said.exit_code != 0
    assert "LNK-FILE" in said.stderr and "pases" in said.stderr and "serving" not in said.stdout
