"""Signing in: what it costs to guess, what a session is, when it ends, and from where a change may come."""

from concurrent.futures import ThreadPoolExecutor

import pytest
from fastapi.testclient import TestClient
from sqlalchemy import select

from tests.support.service import ORIGIN, PASSWORD, Caller, Running, problem, started
from trueloop.errors import Code, TrueloopError
from trueloop.server.app import create_app
from trueloop.server.identity.accounts import accounts, hashed
from trueloop.server.settings import Settings
from trueloop.storage.schema import ACCOUNT, SESSION
from trueloop.storage.store import Store


def test_signing_in_and_out(service: Running) -> None:
    otto = service.signed_in("operator")
    assert otto.get("me").json()["role"] == "operator"
    cookie = otto.client.cookies["session"]
    assert otto.ask("DELETE", "session").status_code == 204
    otto.client.cookies.set("session", cookie)
    assert problem(otto.get("me")) == "SRV-SIGN-IN"


def test_the_cookie_is_for_no_script_and_no_other_site(service: Running) -> None:
    said = service.caller().post("session", {"name": "viewer", "password": PASSWORD}).headers["set-cookie"]
    parts = {part.strip().casefold() for part in said.split(";")[1:]}
    assert {"httponly", "samesite=lax", "path=/"} <= parts
    assert not any(part.startswith("domain") for part in parts)


def test_over_tls_the_cookie_is_tied_to_host_and_tls(store: Store) -> None:
    service = started(store, Settings(tls=True))
    caller = service.caller()
    answer = caller.post(
        "https://localhost/api/v1/session"[len("https://localhost") :],
        {"name": "viewer", "password": PASSWORD},
        headers={"Origin": "https://localhost"},
    )
    assert answer.status_code == 200
    said = answer.headers["set-cookie"]
    assert said.startswith("__Host-session=") and "Secure" in said
    assert "max-age=" in answer.headers["strict-transport-security"]


def test_only_hashes_are_stored(service: Running) -> None:
    cookie = service.signed_in("viewer").client.cookies["session"]
    with service.store.reading() as connection:
        stored = repr(connection.execute(select(SESSION)).all()) + repr(connection.execute(select(ACCOUNT)).all())
    assert cookie not in stored and PASSWORD not in stored
    assert "$argon2id$v=19$m=19456,t=2,p=1$" in stored


def test_a_session_id_that_was_planted_is_not_taken(service: Running) -> None:
    """Session fixation."""
    caller = service.caller()
    caller.client.cookies.set("session", "planted")
    answer = caller.post("session", {"name": "viewer", "password": PASSWORD})
    new = answer.headers["set-cookie"].split("=", 1)[1].split(";")[0]
    assert new != "planted" and len(new) >= 43
    caller.client.cookies.clear()
    caller.client.cookies.set("session", "planted")
    assert problem(caller.get("me")) == "SRV-SIGN-IN"


def test_signing_in_anew_ends_the_old_session(service: Running) -> None:
    caller = service.signed_in("viewer")
    old = caller.client.cookies["session"]
    caller.post("session", {"name": "operator", "password": PASSWORD})
    assert caller.client.cookies["session"] != old
    caller.client.cookies.clear()
    caller.client.cookies.set("session", old)
    assert problem(caller.get("me")) == "SRV-SIGN-IN"


def test_a_page_that_nobody_touches_does_not_keep_its_session_open(service: Running) -> None:
    otto = service.signed_in("viewer")
    for _ in range(3):
        service.clock.turn(minutes=19)
        assert otto.get("today", headers={"Looking-On": "1"}).status_code == 200
    service.clock.turn(minutes=4)
    assert problem(otto.get("today", headers={"Looking-On": "1"})) == "SRV-SIGN-IN"


def test_a_session_ends_when_it_is_not_used(service: Running) -> None:
    otto = service.signed_in("viewer")
    for _ in range(3):
        service.clock.turn(minutes=59)
        assert otto.get("me").status_code == 200
    service.clock.turn(minutes=61)
    assert problem(otto.get("me")) == "SRV-SIGN-IN"


def test_a_session_ends_however_much_it_is_used(service: Running) -> None:
    otto = service.signed_in("viewer")
    for _ in range(23):
        service.clock.turn(minutes=30)
        assert otto.get("me").status_code == 200
    service.clock.turn(minutes=31)
    assert problem(otto.get("me")) == "SRV-SIGN-IN"


@pytest.mark.parametrize("change", [{"role": "viewer"}, {"disabled": True}, {"password": "another one entirely"}])
def test_a_change_of_rights_ends_the_session_at_once(service: Running, change: dict[str, object]) -> None:
    otto, admin = service.signed_in("engineer"), service.signed_in("admin")
    tag = next(one["etag"] for one in admin.get("accounts").json()["items"] if one["name"] == "engineer")
    changed = admin.ask("PATCH", "accounts/engineer", json=change, headers={"If-Match": f'"{tag}"'})
    assert changed.status_code == 200
    assert problem(otto.get("me")) == "SRV-SIGN-IN"


def test_a_change_of_an_account_says_of_which_state(service: Running) -> None:
    admin = service.signed_in("admin")
    assert problem(admin.ask("PATCH", "accounts/viewer", json={"role": "operator"})) == "SRV-MATCH"
    stale = admin.ask("PATCH", "accounts/viewer", json={"role": "operator"}, headers={"If-Match": '"7"'})
    assert (stale.status_code, problem(stale)) == (412, "SRV-STALE")


def test_the_last_administrator_stays(service: Running) -> None:
    admin = service.signed_in("admin")
    refused = admin.ask("PATCH", "accounts/admin", json={"role": "viewer"}, headers={"If-Match": '"1"'})
    assert problem(refused) == "SRV-ACCOUNT"
    assert admin.get("me").json()["role"] == "admin"


def test_guessing_takes_ever_longer(service: Running) -> None:
    """Brute force: after five tries each has to wait, the right password among them."""
    caller = service.caller()
    for _ in range(5):
        assert problem(caller.post("session", {"name": "admin", "password": "wrong wrong wrong"})) == "SRV-LOGIN"
    late = caller.post("session", {"name": "admin", "password": PASSWORD})
    assert (late.status_code, problem(late)) == (429, "SRV-DELAY")
    assert int(late.headers["retry-after"]) >= 1
    service.clock.turn(seconds=3)
    assert caller.post("session", {"name": "admin", "password": PASSWORD}).status_code == 200


def test_guessing_from_one_address_waits_whatever_the_names(service: Running) -> None:
    caller = service.caller()
    codes = [problem(caller.post("session", {"name": f"n{k}", "password": "x" * 12})) for k in range(25)]
    assert codes == ["SRV-LOGIN"] * 20 + ["SRV-DELAY"] * 5


def test_many_guesses_at_once_are_no_more_than_one_after_the_other(service: Running) -> None:
    caller = service.caller()

    def guess(_: int) -> str:
        return problem(caller.post("session", {"name": "admin", "password": "wrong wrong wrong"}))

    with ThreadPoolExecutor(8) as pool:
        codes = list(pool.map(guess, range(16)))
    assert codes.count("SRV-LOGIN") == 5


def test_a_clock_that_was_a_day_ahead_locks_nothing(service: Running) -> None:
    caller = service.caller()
    service.clock.set(days=1)
    assert problem(caller.post("session", {"name": "viewer", "password": "wrong wrong wrong"})) == "SRV-LOGIN"
    service.clock.set(days=-1)
    for name in ("viewer", "operator"):
        assert caller.post("session", {"name": name, "password": PASSWORD}).status_code == 200


@pytest.mark.parametrize(("ahead_min", "stays"), [(24 * 60, False), (10, True)])
def test_a_session_of_a_clock_that_was_ahead_is_not_open_for_longer(
    service: Running, ahead_min: float, stays: bool
) -> None:
    service.clock.set(minutes=ahead_min)
    otto = service.signed_in("viewer")
    service.clock.set(minutes=-ahead_min)
    assert otto.get("me").status_code == (200 if stays else 401)
    service.clock.turn(minutes=61)
    assert problem(otto.get("me")) == "SRV-SIGN-IN"


def test_setting_the_clock_does_not_shorten_the_delay(service: Running) -> None:
    caller = service.caller()
    for _ in range(5):
        caller.post("session", {"name": "admin", "password": "wrong wrong wrong"})
    service.clock.set(days=1)
    assert problem(caller.post("session", {"name": "admin", "password": PASSWORD})) == "SRV-DELAY"


@pytest.mark.parametrize("count", [6, 24])
def test_right_sign_ins_at_once_are_all_taken(service: Running, count: int) -> None:
    def begin(_: int) -> int:
        return service.caller().post("session", {"name": "operator", "password": PASSWORD}).status_code

    with ThreadPoolExecutor(count) as pool:
        assert list(pool.map(begin, range(count))) == [200] * count


def test_a_store_that_was_away_is_no_failed_attempt(service: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    def away(*_: object) -> None:
        raise TrueloopError(Code.STO_FILE, "0 answers", hint="wait")

    with monkeypatch.context() as patched:
        patched.setattr("trueloop.server.routes.session.sessions.account_by_password", away)
        for _ in range(8):
            answer = service.caller().post("session", {"name": "viewer", "password": PASSWORD})
            assert (answer.status_code, problem(answer)) == (503, "STO-FILE") and answer.headers["retry-after"]
    assert service.signed_in("viewer").get("me").status_code == 200


def test_unknown_and_disabled_names_answer_as_wrong_passwords_do(service: Running) -> None:
    admin = service.signed_in("admin")
    admin.ask("PATCH", "accounts/viewer", json={"disabled": True}, headers={"If-Match": '"1"'})
    caller = service.caller()
    answers = [
        caller.post("session", {"name": name, "password": password}).json() | {"detail": ""}
        for name, password in (("nobody", PASSWORD), ("viewer", PASSWORD), ("operator", "wrong wrong wrong"))
    ]
    assert answers[0] == answers[1] == answers[2]


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "", "https://localhost", "http://localhost:81"])
def test_a_change_from_another_site_is_refused(service: Running, origin: str) -> None:
    """CSRF."""
    admin = service.signed_in("admin")
    body = {"name": "mallory", "role": "admin", "password": "mallory is an admin"}
    refused = admin.post("accounts", body, headers={"Origin": origin})
    assert (refused.status_code, problem(refused)) == (403, "SRV-ORIGIN")
    login = service.caller().post("session", {"name": "viewer", "password": PASSWORD}, headers={"Origin": origin})
    assert problem(login) == "SRV-ORIGIN"
    assert [one["name"] for one in admin.get("accounts").json()["items"]].count("mallory") == 0


def test_a_host_name_that_is_not_ours_is_refused(service: Running) -> None:
    """DNS rebinding."""
    answer = service.caller().get("me", headers={"Host": "evil.example"})
    assert (answer.status_code, problem(answer)) == (421, "SRV-HOST")


def test_a_key_is_no_cookie_and_a_cookie_no_key(service: Running) -> None:
    cell = service.cell()
    key = cell.headers["Authorization"].split()[1]
    as_cookie = service.caller()
    as_cookie.client.cookies.set("session", key)
    assert problem(as_cookie.get("me")) == "SRV-SIGN-IN"
    otto = service.signed_in("admin")
    cookie = otto.client.cookies["session"]
    assert problem(service.caller().get("me", headers={"Authorization": f"Bearer {cookie}"})) == "SRV-KEY"
    assert problem(otto.get("me", headers={"Authorization": "Bearer tl_wrong"})) == "SRV-KEY"
    assert problem(cell.get("me")) == "SRV-KEY"


def test_a_key_ends(service: Running) -> None:
    metrics = service.signed_in("admin").post(
        "keys", {"machine": "", "name": "prometheus", "days": 1, "scope": "metrics"}
    )
    headers = {"Authorization": f"Bearer {metrics.json()['key']}"}
    assert service.caller().get("/metrics", headers=headers).status_code == 200
    service.clock.turn(hours=24)
    assert problem(service.caller().get("/metrics", headers=headers)) == "SRV-KEY"


@pytest.mark.parametrize(
    ("password", "taken"),
    [
        *(("a" * 12, False), ("elevenchars", False), ("x" * 129, False), ("aB3$" * 18, False)),
        *(("password1234", False), ("qwertyuiop123", False), ("Passwort2024!", False), ("trueloop1234", False)),
        *(("new new new new", False), ("admin and so on", True), ("x2 y3 z4 w5 v", True)),
        *(("Sommer2024!!", False), ("S0mmer-2024!!", False), ("Werkstatt2025", False), ("W3rkst4tt2025", False)),
        *(("machine-shop1", False), ("Fräsen2025!!!", False), ("Fraesen-2025!", False), ("sinumerik840d", False)),
        *(("correcthorsebatterystaple", False), ("Correct-Horse-Battery-Staple", False), ("new20252026!", False)),
        *(
            ("Zahnrad-Birne-Kabel", True),
            ("spindle otter plum kite", True),
            ("kQ7#vd92LmxZp1", True),
            ("kX#9!v$2@p^&T)q", True),
        ),
    ],
)
def test_which_passwords_are_taken(service: Running, password: str, taken: bool) -> None:
    body = {"name": "new", "role": "viewer", "password": password}
    root = service.signed_in("admin")
    answer = root.post("accounts", body)
    assert answer.status_code == 201 if taken else problem(answer) == "SRV-PASSWORD"
    mine = root.ask("PATCH", "me", json={"password": password, "present_password": PASSWORD})
    assert mine.status_code == 200 if taken else problem(mine) == "SRV-PASSWORD"


def test_a_new_password_needs_the_present_one(service: Running) -> None:
    otto = service.signed_in("operator")
    new = {"password": "another one entirely", "present_password": "wrong wrong wrong"}
    assert problem(otto.ask("PATCH", "me", json=new)) == "SRV-LOGIN"
    assert otto.ask("PATCH", "me", json={**new, "present_password": PASSWORD}).status_code == 200
    assert problem(otto.get("me")) == "SRV-SIGN-IN"
    assert service.caller().post("session", {"name": "operator", "password": new["password"]}).status_code == 200


def test_the_pages_come_from_here_alone(service: Running) -> None:
    page = service.caller().get("/orders")
    policy = page.headers["content-security-policy"]
    assert "script-src 'self';" in policy and "frame-ancestors 'none'" in policy and "unsafe" not in policy
    assert ORIGIN not in policy
    assert service.caller().get("/orders").headers["content-security-policy"] != policy  # a nonce is used once


def test_the_first_account_needs_the_secret_that_was_printed_and_is_made_once(store: Store) -> None:
    app = create_app(store, Settings(workers=0))
    client = Caller(TestClient(app, base_url=ORIGIN, raise_server_exceptions=False))
    assert client.get("session/ways").json()["accounts"] is False
    secret = app.state.first.fragment.removeprefix("#first=")
    otto = {"name": "otto", "password": PASSWORD}
    another = create_app(store, Settings(workers=0)).state.first.fragment.removeprefix("#first=")
    assert len({"", secret, another}) == 3
    for wrong in ("", another, secret[:-1], f"{secret}ä"):
        assert problem(client.post("session/first", {"secret": wrong, **otto})) == "SRV-ACCOUNT"
    assert accounts(store) == []
    elsewhere = {"Origin": "http://evil.example"}
    assert problem(client.post("session/first", {"secret": secret, **otto}, headers=elsewhere)) == "SRV-ORIGIN"
    made = client.post("session/first", {"secret": secret, "language": "de", **otto})
    assert made.status_code == 200 and (made.json()["role"], made.json()["language"]) == ("admin", "de")
    assert client.get("me").json()["name"] == "otto"
    again = client.post("session/first", {"secret": secret, "name": "eve", "password": PASSWORD})
    assert problem(again) == "SRV-ACCOUNT" and [one.name for one in accounts(store)] == ["otto"]
    assert client.get("session/ways").json()["accounts"] is True and app.state.first.fragment == ""


@pytest.mark.parametrize("password", ["anna.meyer2024", "Meyer-Anna-1987", "4nn4.M3y3r-99", "example2025!!"])
def test_the_name_or_address_of_the_account_is_no_password(password: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        hashed(password, "anna.meyer@shop.example")
    assert refused.value.code is Code.SRV_PASSWORD
