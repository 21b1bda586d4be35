"""How many quick requests are worked on at a time."""

import asyncio
from typing import Final

from tests.support.awaited import awaited
from trueloop.server.access import ACCESS
from trueloop.server.turns import AT_ONCE, turn

REQUESTS: Final = 7


async def _most_at_once() -> int:
    inside, most = 0, 0

    async def request() -> None:
        nonlocal inside, most
        async with turn():
            inside += 1
            most = max(most, inside)
            await asyncio.sleep(0)
            inside -= 1

    await asyncio.gather(*(request() for _ in range(REQUESTS)))
    return most


def test_no_more_than_so_many_at_once_in_each_loop() -> None:
    assert [awaited(_most_at_once()) for _ in range(2)] == [AT_ONCE, AT_ONCE]


async def _next_after_a_failure() -> str:
    for _ in range(AT_ONCE + 1):
        try:
            async with turn():
                raise ValueError
        except ValueError:
            pass
    async with turn():
        return "served"


def test_a_request_that_fails_leaves_its_turn_to_the_next() -> None:
    assert awaited(asyncio.wait_for(_next_after_a_failure(), 10)) == "served"


def test_what_changes_streams_or_draws_does_not_queue_with_them() -> None:
    quick = {path for (method, path), access in ACCESS.items() if access.quick}
    assert {method for (method, path), access in ACCESS.items() if access.quick} == {"GET"}
    assert quick >= {"/parts", "/parts/{id}/life", "/orders", "/today"}
    slow = ("/events", "/machines/{name:path}/trace", "/machines/{name:path}/corrector", "/proposals/{id}/picture")
    assert quick.isdisjoint((*slow, "/charts/{part_type:path}", "/diagnosis/part/{serial:path}"))
