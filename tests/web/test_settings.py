"""What people change of themselves, and administrators of others: passwords, roles, keys."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.support.factory import OPERATOR, SHA, Shop
from tests.support.new_stores import new_file
from tests.support.served import WIDE, Browsing, Window, served, sign_in
from tests.support.service import PASSWORD
from tests.web.test_files import usable
from trueloop.factory import requests as ask
from trueloop.factory.requests import By, Role
from trueloop.factory.shown.machines import heard
from trueloop.jobs.store.codec import store_codec
from trueloop.server.identity.keys import keys, of_bearer
from trueloop.server.settings import now
from trueloop.storage.store import Store, open_store

NEW = "quite another four words"


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    found = open_store(new_file(tmp_path / "trueloop.db"), codec=store_codec())
    yield found
    found.close()


@pytest.fixture
def own(store: Store, web: Browsing) -> Iterator[Browsing]:
    """The same browser on a service of its own, which a test may change."""
    with served(store) as address:
        yield Browsing(web.browser, address)


def change_password(window: Window, present: str) -> None:
    form = window.page.get_by_role("form", name="Another password")
    form.get_by_label("Present password", exact=True).fill(present)
    form.get_by_label("New password", exact=True).fill(NEW)
    change = form.get_by_role("button", name="Change the password")
    form.get_by_label("New password once more", exact=True).fill(NEW[:-1])
    expect(form).to_contain_text("the two are not the same")
    expect(change).to_be_disabled()
    form.get_by_label("New password once more", exact=True).fill(NEW)
    change.click()


def test_who_changes_his_password_signs_in_with_the_new_one(own: Browsing) -> None:
    with own.window() as window:
        sign_in(window, "viewer")
        window.go("/settings")
        change_password(window, "not the one that holds")
        expect(window.page.get_by_role("alert")).to_contain_text("SRV-LOGIN")
        change_password(window, PASSWORD)
        expect(window.page.get_by_role("button", name="Sign in")).to_be_visible()
        sign_in(window, "viewer", NEW)


def test_the_language_that_was_chosen_is_that_of_the_next_window(own: Browsing) -> None:
    with own.window("viewer") as window:
        window.go("/settings")
        window.page.get_by_label("Language").select_option("de")
        expect(window.page.get_by_role("heading", level=1, name="Einstellungen")).to_be_visible()
        assert window.complaints == []
    with own.window("viewer") as window:
        window.go("/settings")
        expect(window.page.get_by_role("heading", level=1, name="Einstellungen")).to_be_visible()


@pytest.mark.parametrize("role", ["viewer", "operator", "engineer"])
def test_accounts_and_keys_are_for_administrators(own: Browsing, role: str) -> None:
    with own.window(role) as window:
        window.go("/settings")
        expect(window.page.get_by_role("heading", name="My account")).to_be_visible()
        assert window.page.get_by_role("heading", name="Keys of machines").count() == 0
        assert window.page.get_by_role("heading", name="Accounts").count() == 0
        assert window.complaints == []


def test_an_account_is_added_then_disabled_and_cannot_sign_in(own: Browsing) -> None:
    with own.window("admin") as window, own.window() as other:
        page = window.page
        window.go("/settings")
        add = page.get_by_role("form", name="Add an account")
        add.get_by_label("Account name").fill("nina")
        add.get_by_label("Shown as").fill("N. Weiss")
        add.get_by_label("First password", exact=True).fill(NEW)
        add.get_by_role("button", name="Add an account").click()
        row = page.get_by_role("row").filter(has_text="N. Weiss")
        expect(row).to_contain_text("active")
        sign_in(other, "nina", NEW)
        page.get_by_label("Account", exact=True).select_option("nina")
        form = page.get_by_role("form", name="Change an account")
        expect(form.get_by_role("button", name="Change an account")).to_be_disabled()
        expect(form).to_contain_text("change something first")
        form.get_by_label("State").select_option("disabled")
        form.get_by_role("button", name="Change an account").click()
        expect(row).to_contain_text("disabled")
        other.page.reload()
        expect(other.page.get_by_role("button", name="Sign in")).to_be_visible()
        assert window.complaints == []


def test_the_last_administrator_stays_one(own: Browsing) -> None:
    with own.window("admin") as window:
        window.go("/settings")
        window.page.get_by_label("Account", exact=True).select_option("admin")
        form = window.page.get_by_role("form", name="Change an account")
        form.get_by_label("Role").select_option("viewer")
        form.get_by_role("button", name="Change an account").click()
        expect(form.get_by_role("alert")).to_contain_text("SRV-ACCOUNT")


def test_a_key_is_shown_once_serves_its_machine_and_ends(own: Browsing, store: Store) -> None:
    with own.window("admin") as window:
        page = window.page
        window.go("/settings")
        make = page.get_by_role("button", name="Make a key")
        page.get_by_label("Name of the key").fill("cell1")
        expect(make).to_be_disabled()
        page.get_by_label("Machine", exact=True).fill("lathe")
        page.get_by_label("Holds, days").fill("401")
        expect(page.locator("main")).to_contain_text("1 to 400 days")
        page.get_by_label("Holds, days").fill("30")
        make.click()
        key = page.get_by_label("Copy this key now").input_value()
        who = of_bearer(store, f"Bearer {key}", now())
        assert (who.name, who.role, who.machine) == ("cell1", "cell", "lathe")
        window.go("/")
        window.go("/settings")
        expect(page.get_by_role("row").filter(has_text="cell1")).to_be_visible()
        assert key not in page.content()
        page.get_by_role("button", name="End this key").click()
        expect(page.get_by_role("row").filter(has_text="cell1")).to_contain_text("ended")
        assert keys(store)[0].ended_at is not None
        assert window.complaints == []


LINKS = """[ftp.mill]
host = "192.168.0.20"
user = "op"
folder = "nc"
[serial.old]
port = "/dev/ttyUSB0"
"""


def test_links_are_shown_with_kind_address_and_what_came_of_the_last_transfer(
    web: Browsing, shown: Store, tmp_path: Path
) -> None:
    (tmp_path / "links.toml").write_text(LINKS, encoding="utf-8")
    with (
        served(shown, links=tmp_path / "links.toml") as address,
        Browsing(web.browser, address).window("engineer") as window,
    ):
        window.go("/settings")
        table = window.page.get_by_role("table", name="Links to controls")
        mill, old = (table.get_by_role("row").filter(has_text=name) for name in ("mill", "old"))
        expect(mill).to_contain_text("ftp://op@192.168.0.20:21/nc")
        expect(mill.locator(".why")).to_have_text("LNK-DIFFERS: 'O2' came back")
        expect(mill.locator(".age")).to_have_count(1)
        expect(mill.get_by_role("link", name="mill")).to_have_attribute("href", "/machines/mill")
        expect(old).to_contain_text("serial line")
        expect(table.get_by_role("row").filter(has_text="lathe").locator(".state.good")).to_have_text(
            "read back, the same"
        )
        usable(window)
        window.resize(WIDE)
        window.page.get_by_role("button", name="Deutsch").click()
        table = window.page.get_by_role("table", name="Verbindungen zu Steuerungen")
        expect(table).to_contain_text("zurückgelesen, gleich")
        (tmp_path / "links.toml").write_text("[ftp.mill]\nhots = 1\n", encoding="utf-8")
        window.page.reload()
        expect(window.page.get_by_role("alert")).to_contain_text("LNK-FILE")


def test_without_settings_of_links_it_says_so_and_lists_the_controls_that_are_known(
    web: Browsing, shown: Store
) -> None:
    with served(shown) as address:
        own = Browsing(web.browser, address)
        with own.window("admin") as window:
            window.go("/settings")
            links = window.page.get_by_role("region", name="Links to controls")
            expect(links).to_contain_text("trueloop serve --links links.toml")
            expect(links.get_by_role("row")).to_have_count(3)
            expect(links.get_by_role("row").filter(has_text="mill")).to_contain_text("LNK-DIFFERS")
            assert window.complaints == []
        with own.window("operator") as window:
            window.go("/settings")
            expect(window.page.get_by_role("heading", name="Transfers")).to_be_visible()
            assert window.page.get_by_role("heading", name="Links to controls").count() == 0
            assert window.complaints == []


@pytest.fixture
def shown(store: Store) -> Store:
    """Transfers to two controls, the last of one refused."""
    shop = Shop(store).set_up()
    told = (("lathe", "read back"), ("mill", "there already"), ("mill", "LNK-DIFFERS: 'O2' came back"))
    for control, outcome in told:
        shop.do(ask.RecordTransfer(control, SHA["finish"], "O2", "to", SHA["finish"], "", outcome), OPERATOR)
    heard(store, "mill", {"state": "idle"}, By("cell", Role.CELL, "mill"), now())
    return store
