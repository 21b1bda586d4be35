"""Signing in by an identity provider: only by a token that holds, only to an account that was linked, only once."""

import json
from base64 import urlsafe_b64decode
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import pytest
from httpx2 import Response
from sqlalchemy import func, select

from tests.support.identity_provider import CLIENT, SECRET, IdentityProvider, Key, b64, identity_provider
from tests.support.refusals import refused
from tests.support.service import Caller, Clock, Running, problem, started
from trueloop.errors import Code
from trueloop.server.identity.accounts import Change, change_account, subject_of
from trueloop.server.identity.oidc import Oidc, Provider, require_safe_issuer
from trueloop.server.settings import Settings
from trueloop.storage.schema import ACCOUNT
from trueloop.storage.store import Store

OTTO = "248289761001"


@pytest.fixture(scope="module")
def key() -> Key:
    return Key("first")


@pytest.fixture(scope="module")
def other_key() -> Key:
    return Key("other")


@dataclass
class Shop:
    """A service that trusts the provider; `operator` is linked to OTTO."""

    service: Running
    provider: IdentityProvider

    def browser(self) -> Caller:
        caller = self.service.caller()
        caller.client.follow_redirects = False
        return caller

    def sent(self, caller: Caller) -> str:
        """Where the browser is sent."""
        answer = caller.get("session/oidc")
        assert answer.status_code == 302
        return answer.headers["location"]

    def back(self, caller: Caller, brought: dict[str, str]) -> Response:
        return caller.get("session/oidc/callback", params=brought)

    def signed_in(self, subject: str = OTTO, caller: Caller | None = None) -> tuple[Caller, Response]:
        caller = caller or self.browser()
        return caller, self.back(caller, self.provider.agreed(self.sent(caller), subject))

    def link(self, name: str, subject: str) -> None:
        wanted = Change(subject=subject_of(self.provider.issuer, subject))
        change_account(self.service.store, name, wanted, self.service.clock())

    def refused(self, subject: str = OTTO) -> str:
        """The code with which a sign-in ends; there is no session then."""
        caller, answer = self.signed_in(subject)
        assert problem(caller.get("me")) == "SRV-SIGN-IN"
        assert "session=" not in answer.headers.get("set-cookie", "")
        return problem(answer)


def shop_of(store: Store, provider: IdentityProvider, **given: Any) -> Shop:
    oidc = replace(Oidc(provider.issuer, CLIENT, SECRET), **given)
    shop = Shop(started(store, clock=Clock(), oidc=oidc), provider)
    shop.link("operator", OTTO)
    return shop


@pytest.fixture
def provider(key: Key) -> Iterator[IdentityProvider]:
    with identity_provider(key, Clock().at.timestamp()) as found:
        yield found


@pytest.fixture
def shop(store: Store, provider: IdentityProvider) -> Shop:
    return shop_of(store, provider)


def test_a_linked_person_signs_in_and_nothing_of_it_is_left(shop: Shop) -> None:
    assert shop.service.caller().get("session/ways").json() == {"oidc": "Single sign-on", "accounts": True}
    caller, answer = shop.signed_in()
    assert (answer.status_code, answer.headers["location"]) == (303, "/")
    assert caller.get("me").json()["name"] == "operator" and shop.provider.refusals == []
    assert "oidc" not in caller.client.cookies
    cookies = answer.headers.get_list("set-cookie")
    assert any(one.startswith("session=") and "HttpOnly" in one and "SameSite=lax" in one for one in cookies)


def test_signing_in_so_ends_the_session_that_was_open(shop: Shop) -> None:
    caller = shop.service.signed_in("viewer")
    caller.client.follow_redirects = False
    old = caller.client.cookies["session"]
    shop.signed_in(caller=caller)
    assert caller.get("me").json()["name"] == "operator"
    caller.client.cookies.clear()
    caller.client.cookies.set("session", old)
    assert problem(caller.get("me")) == "SRV-SIGN-IN"


def test_over_tls_the_cookie_of_a_sign_in_is_tied_to_this_host(store: Store, provider: IdentityProvider) -> None:
    service = started(store, Settings(tls=True), oidc=Oidc(provider.issuer, CLIENT, SECRET))
    caller = service.caller()
    caller.client.follow_redirects = False
    answer = caller.get("session/oidc")
    assert answer.headers["set-cookie"].startswith("__Host-oidc=") and "Secure" in answer.headers["set-cookie"]
    assert "redirect_uri=https%3A%2F%2Flocalhost%2F" in answer.headers["location"]


def test_a_state_serves_once_for_ten_minutes_and_the_browser_that_began(shop: Shop) -> None:
    caller = shop.browser()
    brought = shop.provider.agreed(shop.sent(caller), OTTO)
    cookie = caller.client.cookies["oidc"]
    assert shop.back(caller, brought).status_code == 303
    caller.client.cookies.set("oidc", cookie)
    assert problem(shop.back(caller, brought)) == "SRV-OIDC"  # replayed
    began, another = shop.browser(), shop.browser()
    shop.sent(another)
    brought = shop.provider.agreed(shop.sent(began), OTTO)
    assert problem(shop.back(another, brought)) == "SRV-OIDC"  # somebody else's sign-in laid into a browser
    late = shop.browser()
    brought = shop.provider.agreed(shop.sent(late), OTTO)
    shop.service.clock.turn(minutes=10)
    assert problem(shop.back(late, brought)) == "SRV-OIDC"
    for wrong in ({}, {"state": "made up", "code": "x"}):
        assert problem(shop.back(shop.browser(), wrong)) == "SRV-OIDC"


@pytest.mark.parametrize(
    "changed",
    [
        {"nonce": "another"}, {"nonce": None}, {"aud": "another"}, {"aud": [CLIENT, "another"]}, {"aud": None},
        {"azp": "another"}, {"iss": "https://another.example"}, {"iss": None}, {"sub": None}, {"sub": ""}, {"sub": 7},
        {"exp": None}, {"exp": 1}, {"exp": "soon"}, {"iat": None}, {"iat": 4e9}, {"nbf": 4e9},
    ],
    ids=str,
)  # fmt: skip
def test_a_token_whose_claims_do_not_hold_is_refused(shop: Shop, changed: dict[str, object]) -> None:
    shop.provider.changed = changed
    assert shop.refused() == "SRV-OIDC"


def test_clocks_may_differ_by_a_minute(shop: Shop) -> None:
    at = int(shop.provider.at_s)
    shop.provider.changed = {"exp": at - 59, "iat": at + 59}
    assert shop.signed_in()[1].status_code == 303
    shop.provider.changed = {"exp": at - 60}
    assert shop.refused() == "SRV-OIDC"


def test_a_token_that_the_provider_did_not_sign_is_refused(shop: Shop, key: Key, other_key: Key) -> None:
    caller = shop.browser()
    for forged in ("none", "other", "named as the first", "by the public key", "changed", "nothing"):
        brought = shop.provider.agreed(shop.sent(caller), OTTO)
        claims = shop.provider.claims(shop.provider.codes[brought["code"]])
        head, body, signature = key.signed(claims).split(".")
        stranger = json.loads(urlsafe_b64decode(body + "==")) | {"sub": "another"}
        shop.provider.token = {
            "none": key.signed(claims, alg="none"),
            "other": other_key.signed(claims),
            "named as the first": other_key.signed(claims, kid="first"),
            "by the public key": f"{b64(json.dumps({'alg': 'HS256', 'kid': 'first'}).encode())}.{body}.{signature}",
            "changed": f"{head}.{b64(json.dumps(stranger).encode())}.{signature}",
            "nothing": "a.b.c",
        }[forged]
        assert problem(shop.back(caller, brought)) == "SRV-OIDC", forged
    assert problem(caller.get("me")) == "SRV-SIGN-IN"


def test_strangers_and_disabled_accounts_do_not_get_in_and_no_account_is_made(shop: Shop) -> None:
    count = select(func.count()).select_from(ACCOUNT)
    with shop.service.store.reading() as connection:
        before = connection.execute(count).scalar_one()
    assert shop.refused("somebody") == "SRV-OIDC"
    change_account(shop.service.store, "operator", Change(disabled=True), shop.service.clock())
    assert shop.refused() == "SRV-OIDC"
    with shop.service.store.reading() as connection:
        assert connection.execute(count).scalar_one() == before


def test_the_same_subject_of_another_provider_is_another_person(shop: Shop) -> None:
    wanted = Change(subject=subject_of("https://another.example", "7"))
    change_account(shop.service.store, "viewer", wanted, shop.service.clock())
    assert shop.refused("7") == "SRV-OIDC"


def test_a_subject_is_linked_to_one_account_and_the_link_ends_with_its_sessions(shop: Shop) -> None:
    caller, _ = shop.signed_in()
    assert refused(shop.link, "viewer", OTTO).code is Code.SRV_ACCOUNT
    change_account(shop.service.store, "operator", Change(subject=""), shop.service.clock())
    assert problem(caller.get("me")) == "SRV-SIGN-IN"
    assert shop.refused() == "SRV-OIDC"


def test_a_claim_gives_the_role_where_that_is_set_up(store: Store, provider: IdentityProvider) -> None:
    roles = (("shop", "operator"), ("planning", "engineer"))
    shop = shop_of(store, provider, role_claim="groups", roles=roles)
    first, _ = shop.signed_in()
    assert problem(first.get("me")) == "SRV-SIGN-IN"  # no claim, no role
    provider.changed = {"groups": ["shop", "planning", "else"]}
    caller, _ = shop.signed_in()
    assert caller.get("me").json()["role"] == "engineer"
    provider.changed = {"groups": "shop"}
    again, _ = shop.signed_in()
    assert again.get("me").json()["role"] == "operator"
    assert problem(caller.get("me")) == "SRV-SIGN-IN"  # another role ends sessions
    provider.changed = {"groups": ["shop planning"]}
    assert shop.refused() == "SRV-OIDC"
    shop.link("admin", "1")
    provider.changed = {"groups": "shop"}
    assert shop.refused("1") == "SRV-OIDC"  # the last administrator stays one


def test_a_provider_that_refuses_or_is_another_is_named(shop: Shop) -> None:
    caller = shop.browser()
    brought = shop.provider.agreed(shop.sent(caller), OTTO)
    answer = shop.back(caller, {"state": brought["state"], "error": "access_denied<script>"})
    assert problem(answer) == "SRV-OIDC" and "access_denied" in answer.text and "<script" not in answer.text
    brought = shop.provider.agreed(shop.sent(caller), OTTO)
    assert problem(shop.back(caller, brought | {"iss": "https://another.example"})) == "SRV-OIDC"
    brought = shop.provider.agreed(shop.sent(caller), OTTO)
    assert problem(shop.back(caller, brought | {"code": "guessed"})) == "SRV-PROVIDER"
    assert shop.provider.refusals[0] == "code"
    shop.provider.calls_itself = "https://another.example"
    shop.service.clock.turn(hours=2)
    assert problem(caller.get("session/oidc")) == "SRV-PROVIDER"


def test_without_a_provider_there_is_no_such_way(store: Store) -> None:
    caller = started(store).caller()
    assert caller.get("session/ways").json() == {"oidc": None, "accounts": True}
    assert problem(caller.get("session/oidc")) == "SRV-UNKNOWN"


@pytest.mark.parametrize("issuer", ["http://login.example", "ftp://127.0.0.1", "https://login.example?x=1", "login"])
def test_an_issuer_that_others_could_play_is_refused(issuer: str) -> None:
    assert refused(require_safe_issuer, issuer).code is Code.SRV_PROVIDER


def test_a_provider_that_does_not_answer_is_named(shop: Shop) -> None:
    assert refused(Provider("http://127.0.0.1:9").found, shop.service.clock()).code is Code.SRV_PROVIDER
