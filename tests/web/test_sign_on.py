"""Signing in by an identity provider in the browser, from the button to Today; where there is none, no button."""

from datetime import UTC, datetime
from pathlib import Path

from playwright.sync_api import expect

from tests.support.axe import findings
from tests.support.identity_provider import CLIENT, SECRET, Key, identity_provider
from tests.support.served import NARROW, Browsing, served
from trueloop.jobs.store.codec import store_codec
from trueloop.server.identity.accounts import Change, change_account, subject_of
from trueloop.server.identity.provider import Oidc
from trueloop.storage.store import open_store

OTTO = "248289761001"
BUTTON = "Shop login"


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
                expect(window.page.get_by_role("navigation")).to_contain_text("operator")
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
