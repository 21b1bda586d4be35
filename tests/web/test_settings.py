"""What people change of themselves, and administrators of others: passwords, roles, keys."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.support.served import Browsing, Window, served, sign_in
from tests.support.service import PASSWORD
from trueloop.jobs.store.codec import store_codec
from trueloop.server.identity.keys import keys, of_bearer
from trueloop.server.settings import now
from trueloop.storage.store import Store, open_store

NEW = "quite another four words"


@pytest.fixture
def store(tmp_path: Path) -> Iterator[Store]:
    found = open_store(str(tmp_path / "trueloop.db"), create=True, codec=store_codec())
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
