"""The first account of a new service, and signing in by an identity provider, from the button to Today."""

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import IO

from playwright.sync_api import expect

from tests.support.axe import findings
from tests.support.identity_provider import CLIENT, SECRET, Key, identity_provider
from tests.support.served import NARROW, Browsing, served
from tests.support.service import PASSWORD
from trueloop.jobs.store.codec import store_codec
from trueloop.server.identity.accounts import Change, change_account, subject_of
from trueloop.server.identity.oidc import Oidc
from trueloop.storage.store import open_store

OTTO = "248289761001"
BUTTON = "Shop login"


@contextmanager
def _serve(folder: Path, left: list[str]) -> Iterator[IO[str]]:
    """`trueloop serve` in a folder: what it prints; `left`: what was not read of it."""
    command = [sys.executable, "-c", "from trueloop.cli.main import main; main()", "serve", "--port", "0"]
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as service:
        assert service.stdout is not None
        try:
            yield service.stdout
        finally:
            service.terminate()
            left.append(service.stdout.read())


def test_one_command_in_an_empty_folder_leads_to_the_first_account_and_to_today(web: Browsing, tmp_path: Path) -> None:
    left: list[str] = []
    with _serve(tmp_path, left) as printed:
        assert "serving" in printed.readline() and (tmp_path / "trueloop.db").is_file()
        found = re.search(r"(http://\S+/)#first=\S+", printed.readline())
        assert found is not None
        with Browsing(web.browser, found[1]).window(size=NARROW) as window:
            window.page.goto(found[1])
            expect(window.page.locator("main")).to_contain_text("Open the link that it printed")
            window.page.goto(found[0])
            window.page.reload()
            window.page.get_by_label("Name").fill("otto")
            password = window.page.get_by_label("Password", exact=True)
            password.fill("short")
            assert findings(window) == []
            window.page.get_by_role("button", name="Make the account").click()
            expect(window.page.get_by_role("alert")).to_contain_text("SRV-PASSWORD")
            password.fill(PASSWORD)
            window.page.keyboard.press("Enter")
            expect(window.page.get_by_role("heading", level=1, name="Today")).to_be_visible()
            assert "first" not in window.page.url
            window.page.get_by_role("button", name="Menu").click()
            expect(window.page.get_by_role("navigation", name="Pages")).to_contain_text("otto")
            window.page.get_by_role("button", name="Sign out").click()
            window.page.goto(found[0])  # it is used up
            expect(window.page.get_by_role("button", name="Sign in")).to_be_visible()
    with _serve(tmp_path, left) as printed:
        assert "serving" in printed.readline()
    assert left == ["", ""]


def test_a_linked_person_signs_in_at_the_provider_and_comes_back_to_today(web: Browsing, tmp_path: Path) -> None:
    store = open_store(str(tmp_path / "trueloop.db"), create=True, codec=store_codec())
    with identity_provider(Key("k"), datetime.now(UTC).timestamp()) as provider:
        provider.person = OTTO
        with served(store, Oidc(provider.issuer, CLIENT, SECRET, label=BUTTON)) as address:
            change_account(store, "operator", Change(subject=subject_of(provider.issuer, OTTO)), datetime.now(UTC))
            with Browsing(web.browser, address).window(size=NARROW) as window:
                window.page.goto(address)
                button = window.page.get_by_role("link", name=BUTTON)
                box = button.bounding_box()
                assert box is not None and box["height"] >= 48
                expect(window.page.get_by_label("Password", exact=True)).to_be_visible()
                assert findings(window) == []
                button.click()
                window.page.get_by_role("link", name="Agree").click()
                expect(window.page.get_by_role("heading", level=1, name="Today")).to_be_visible()
                window.page.get_by_role("button", name="Menu").click()
                expect(window.page.get_by_role("navigation", name="Pages")).to_contain_text("operator")
                assert "code=" not in window.page.url and provider.refusals == []
                assert [one for one in window.complaints if "401" not in one] == []
                window.page.get_by_role("button", name="Sign out").click()
                expect(button).to_be_visible()
    store.close()


def test_a_stranger_is_told_so_where_one_signs_in(web: Browsing, tmp_path: Path) -> None:
    store = open_store(str(tmp_path / "trueloop.db"), create=True, codec=store_codec())
    with identity_provider(Key("k"), datetime.now(UTC).timestamp()) as provider:
        provider.person = OTTO
        with (
            served(store, Oidc(provider.issuer, CLIENT, SECRET, label=BUTTON)) as address,
            Browsing(web.browser, address).window(size=NARROW) as window,
        ):
            window.page.goto(address)
            window.page.get_by_role("link", name=BUTTON).click()
            window.page.get_by_role("link", name="Agree").click()
            expect(window.page.get_by_role("alert")).to_contain_text("did not sign you in")
            expect(window.page.get_by_role("alert")).to_contain_text("SRV-OIDC")
            assert "code=" not in window.page.url and findings(window) == []
            window.page.goto(f"{address}/?refused=<script>")
            expect(window.page.get_by_role("button", name="Sign in")).to_be_visible()
            assert window.page.get_by_role("alert").count() == 0
    store.close()


def test_without_a_provider_there_is_no_button(web: Browsing) -> None:
    with web.window() as window:
        with window.page.expect_response("**/session/ways"):
            window.page.goto(web.address)
        expect(window.page.get_by_role("button", name="Sign in")).to_be_visible()
        assert window.page.get_by_role("link").count() == 0
