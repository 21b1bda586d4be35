"""A POST whose answer never came is not done again: its sender learns what is known of it."""

import pytest

from tests.support.factory import Shop
from tests.support.service import Running, problem
from trueloop.errors import Code, TrueloopError
from trueloop.server import once
from trueloop.server.routes import changes

HOLD = {"part": 1, "why": "scratched"}
KEY = {"Idempotency-Key": "k-1"}


@pytest.fixture
def order(service: Running) -> str:
    return Shop(service.store, service.clock()).set_up().order


def held(service: Running) -> int:
    """How often the part was held."""
    life = service.signed_in("viewer").get("parts/1/life").json()
    return [one["what"] for one in life["events"]].count("held")


def killed(*_: object) -> None:
    raise OSError("killed")


def hold(service: Running, order: str) -> str:
    otto = service.signed_in("operator")
    etag = otto.get(f"orders/{order}").headers["etag"]
    answer = otto.post(f"orders/{order}/hold", HOLD, headers=KEY | {"If-Match": etag})
    return "done" if answer.status_code == 200 else f"{problem(answer)} {answer.json()['detail']}"


def test_killed_before_its_answer_was_kept(service: Running, order: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as cut:
        cut.setattr(once, "finish", killed)
        hold(service, order)
    assert held(service) == 1
    said = hold(service, order)
    assert said.startswith("SRV-REUSED") and "was done, and its answer was lost" in said
    assert held(service) == 1


def test_a_change_whose_answer_cannot_be_shown_is_not_made_twice(
    service: Running, order: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where the answer fails as a refusal would: what was changed was changed."""

    def broken(*_: object) -> None:
        raise TrueloopError(Code.FAC_UNKNOWN, "0 rows", hint="look")

    with monkeypatch.context() as cut:
        cut.setattr(changes, "order_view", broken)
        assert hold(service, order).startswith("FAC-UNKNOWN")
    assert held(service) == 1
    assert "was done, and its answer was lost" in hold(service, order)
    assert held(service) == 1


def test_killed_before_it_was_done(service: Running, order: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as cut:
        cut.setattr(changes, "carry_out", killed)
        cut.setattr(once, "give_up", lambda *_: None)
        hold(service, order)
    said = hold(service, order)
    assert said.startswith("SRV-REUSED") and "was begun at" in said and "no answer yet" in said
    assert held(service) == 0


def test_a_refusal_leaves_the_key_free(service: Running, order: str) -> None:
    otto = service.signed_in("operator")
    stale = otto.post(f"orders/{order}/hold", HOLD, headers=KEY | {"If-Match": '"0"'})
    assert problem(stale) == "FAC-STALE"
    assert hold(service, order) == "done" and held(service) == 1
