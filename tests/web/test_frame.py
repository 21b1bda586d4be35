"""Signing in, languages, colours, and what is shown when the service is silent."""

import re

from playwright.sync_api import expect

from tests.support.served import WIDE, Browsing, sign_in


def test_a_wrong_password_is_refused_with_code_and_hint(web: Browsing) -> None:
    with web.window() as window:
        window.page.goto(web.address + "/orders")
        window.page.get_by_label("Name").fill("otto")
        window.page.get_by_label("Password", exact=True).fill("guessed")
        window.page.keyboard.press("Enter")
        refused = window.page.get_by_role("alert")
        expect(refused).to_contain_text("SRV-LOGIN")
        assert [one for one in window.complaints if "401" not in one] == []


def test_who_signs_out_sees_nothing_any_more(web: Browsing) -> None:
    with web.window() as window:
        sign_in(window, "operator")
        window.go("/orders")
        expect(window.page.locator("main")).to_contain_text("O1")
        window.page.get_by_role("button", name="Sign out").click()
        expect(window.page.get_by_role("button", name="Sign in")).to_be_visible()
        assert "O1" not in window.page.content()


def test_all_is_said_in_german_too_and_stays_so(web: Browsing) -> None:
    with web.window() as window:
        sign_in(window, "operator")
        window.page.get_by_role("button", name="Deutsch").click()
        expect(window.page.get_by_role("heading", name="Wartet auf Sie")).to_be_visible()
        assert window.page.evaluate("document.documentElement.lang") == "de"
        window.page.reload()
        expect(window.page.get_by_role("heading", name="Wartet auf Sie")).to_be_visible()
        window.page.get_by_role("button", name="English").click()
        expect(window.page.get_by_role("heading", name="Waits for you")).to_be_visible()


def test_colours_are_those_of_the_system_until_chosen(web: Browsing) -> None:
    ground = "getComputedStyle(document.body).backgroundColor"
    with web.window("viewer", dark=True) as window:
        window.go("/")
        dark = window.page.evaluate(ground)
        window.page.get_by_role("button", name="Light").click()
        expect(window.page.get_by_role("button", name="Dark")).to_be_visible()
        assert window.page.evaluate(ground) != dark


def test_silence_is_said_and_what_was_known_stays_in_grey(web: Browsing) -> None:
    with web.window("operator") as window:
        window.page.clock.install()
        window.go("/")
        expect(window.page.locator(".contact")).to_have_text(re.compile(r"live \d\d:\d\d:\d\d"))
        window.page.context.set_offline(True)
        window.page.clock.fast_forward(15_000)
        expect(window.page.locator(".contact")).to_contain_text(re.compile("no contact for|kein Kontakt"))
        expect(window.page.locator("main")).to_contain_text("lathe")
        assert window.page.evaluate("getComputedStyle(document.querySelector('main')).filter") == "grayscale(1)"
        window.page.context.set_offline(False)
        window.page.clock.run_for(5000)
        expect(window.page.locator(".contact")).to_contain_text("live")


def test_a_machine_that_is_silent_is_grey_with_its_last_values(web: Browsing) -> None:
    with web.window("viewer") as window:
        window.go("/")
        row = window.page.get_by_role("row").filter(has_text="face.ngc")
        assert "stale" in (row.get_attribute("class") or "")
        expect(row).to_contain_text(re.compile(r"\d\d:\d\d:\d\d · \d+ mins? ago"))


def test_the_keyboard_goes_everywhere(web: Browsing) -> None:
    with web.window("engineer", WIDE) as window:
        window.go("/")
        window.page.keyboard.press("Tab")
        assert window.page.evaluate("document.activeElement.className") == "skip"
        order = window.page.get_by_role("link", name="Orders", exact=True)
        for _ in range(10):
            window.page.keyboard.press("Tab")
            if order.evaluate("one => one === document.activeElement"):
                break
        assert order.evaluate("one => getComputedStyle(one).outlineStyle") == "solid"
        window.page.keyboard.press("Enter")
        expect(window.page.get_by_role("heading", level=1, name="Orders")).to_be_visible()


def test_capability_stands_with_its_count_or_why_there_is_none(web: Browsing) -> None:
    with web.window("viewer") as window:
        for path in ("/", "/wall"):
            window.go(path)
            expect(window.page.locator(".counts")).to_contain_text("Cpk dome, shaft")
            expect(window.page.locator(".counts")).to_contain_text("1 part; it needs 20")
