"""The service over HTTP in this process, and a real browser on its pages."""

import shutil
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic
from typing import Any

import uvicorn
from playwright.sync_api import Browser, BrowserContext, Dialog, Page, expect, sync_playwright

from tests.support.chromium import INSTALL, ChromiumMissingError
from tests.support.corrector import trace
from tests.support.service import PASSWORD
from trueloop.controllers.linuxcnc.cell.client import Service
from trueloop.server.app import create_app
from trueloop.server.identity.accounts import NewAccount, add_account
from trueloop.server.identity.keys import ROLES, NewKey, add_key
from trueloop.server.identity.oidc import Oidc
from trueloop.server.run import Listening, config_of, listen
from trueloop.server.settings import LOOPBACK_NAMES, Settings
from trueloop.storage.store import Store

WAIT_S = 60  # a reading starts a process of its own: seconds beside other tests on the same cores
WIDE, NARROW = (1400, 900), (400, 800)
FLAGS = ("--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--disable-background-networking")


@contextmanager
def served(
    store: Store,
    oidc: Oidc | None = None,
    links: Path | None = None,
    proxies: tuple[str, ...] = (),
    names: tuple[str, ...] = (),
) -> Iterator[str]:
    """The service on a store, at an address of this machine; accounts of every role, named as the role.

    `links`: the settings of links to controls that it is told of.
    """
    for role in ROLES:
        add_account(store, NewAccount(role, role, PASSWORD), datetime.now(UTC))
    where = Listening(port=0, proxies=proxies)
    names = (*LOOPBACK_NAMES, *names)
    app = create_app(store, Settings(where.tls, names, poll_s=0.05, workers=0, links=links), oidc=oidc)
    with listen(where) as socket:
        server = uvicorn.Server(config_of(app, where))
        thread = threading.Thread(target=server.run, args=([socket],), daemon=True)
        thread.start()
        try:
            yield f"http://127.0.0.1:{socket.getsockname()[1]}"
        finally:
            app.state.stopping.set()
            server.should_exit = True
            thread.join(WAIT_S)


def tell_corrector(store: Store, address: str, machine: str = "lathe", **what: Any) -> None:
    """As `trueloop realtime watch` beside the machine does."""
    key = add_key(store, NewKey(machine, "watch", 1), "test", datetime.now(UTC)).key
    with closing(Service(address, key)) as service:
        service.trace(trace(**what))


@dataclass
class Window:
    """A page, and everything that the browser complained of on it."""

    page: Page
    address: str
    complaints: list[str] = field(default_factory=list)

    def go(self, path: str) -> None:
        """Goes to a page as a link there does, without loading all anew, and waits until it shows its answers."""
        if self.page.url.startswith(self.address):
            self.page.evaluate("path => history.pushState(null, '', path)", path)
        else:
            self.page.goto(self.address + path)
        self.settled()

    def resize(self, size: tuple[int, int]) -> None:
        """Makes the window as large, in CSS pixels."""
        self.page.set_viewport_size({"width": size[0], "height": size[1]})

    def until(self, said: str, given: Any = None) -> None:
        """Waits until JavaScript says yes; asked from here, for the page's own policy forbids a text as a script."""
        end = monotonic() + WAIT_S
        while not self.page.evaluate(said, given):
            assert monotonic() < end, said
            self.page.wait_for_timeout(50)

    def settled(self) -> None:
        """The page has its heading, and nothing is being loaded."""
        self.page.locator("main h1").first.wait_for()
        expect(self.page.locator("main .mantine-Loader-root")).to_have_count(0)


@dataclass
class Browsing:
    """A browser on one service."""

    browser: Browser
    address: str
    signed: dict[str, Any] = field(default_factory=dict)

    @contextmanager
    def window(
        self, role: str = "", size: tuple[int, int] = WIDE, *, dark: bool = False, locale: str = "en-GB"
    ) -> Iterator[Window]:
        """A window of somebody signed in; without a role nobody is yet. Each role signs in once, as a person does."""
        if role and role not in self.signed:
            with self.window() as first:
                sign_in(first, role)
                self.signed[role] = first.page.context.storage_state()
        context = self.browser.new_context(
            viewport={"width": size[0], "height": size[1]},
            color_scheme="dark" if dark else "light",
            locale=locale,
            storage_state=self.signed.get(role),
        )
        context.set_default_timeout(WAIT_S * 1000)
        try:
            yield _heard(context, self.address)
        finally:
            context.close()


def sign_in(window: Window, role: str, password: str = PASSWORD) -> None:
    """By the form."""
    window.page.goto(window.address)
    window.page.get_by_label("Name").fill(role)
    window.page.get_by_label("Password", exact=True).fill(password)
    window.page.get_by_role("button", name="Sign in").click()
    expect(window.page.get_by_label("Password", exact=True)).to_have_count(0)  # that page, too, has its heading
    window.settled()


def _heard(context: BrowserContext, address: str) -> Window:
    """Scripts that fail, answers that are missing, what the policy forbids, and dialogs: no page of ours has one."""
    window = Window(context.new_page(), address)

    def dialog(one: Dialog) -> None:
        window.complaints.append(f"dialog: {one.message}")
        one.dismiss()

    window.page.on("console", lambda one: window.complaints.append(one.text) if one.type != "log" else None)
    window.page.on("pageerror", lambda error: window.complaints.append(str(error)))
    window.page.on("dialog", dialog)
    return window


@contextmanager
def browsing(address: str) -> Iterator[Browsing]:
    """Headless Chromium of the system; none is downloaded."""
    program = shutil.which("chromium")
    if program is None:
        raise ChromiumMissingError(f"Chromium is not installed; run as root:  {INSTALL}")
    expect.set_options(timeout=WAIT_S * 1000)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        try:
            yield Browsing(browser, address)
        finally:
            browser.close()
