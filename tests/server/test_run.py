"""The socket that the service listens at."""

import asyncio
import socket
from contextlib import closing
from pathlib import Path

import pytest

from tests.support.awaited import awaited
from tests.support.cli import invoke
from trueloop.errors import Code
from trueloop.server.run import Listening, listen


async def _sends_at_once() -> list[int]:
    """TCP_NODELAY of a connection that asyncio has taken."""
    found: list[int] = []

    async def taken(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        found.append(writer.get_extra_info("socket").getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
        writer.close()

    with listen(Listening(port=0)) as listening:
        async with await asyncio.start_server(taken, sock=listening):
            reader, writer = await asyncio.open_connection(*listening.getsockname())
            await asyncio.wait_for(reader.read(), 10)
            with closing(writer):
                return found


def test_an_answer_in_two_pieces_does_not_wait_for_the_client() -> None:
    """Else each answer takes the 40 ms after which Linux acknowledges what it has nothing to say to."""
    assert awaited(_sends_at_once()) == [1]


@pytest.mark.parametrize("shop", [(), ("--demo",)], ids=["", "demo"])
def test_a_port_that_is_taken_leaves_no_store_behind(
    shop: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    with listen(Listening(port=0)) as taken:
        refused = invoke("serve", "--port", str(taken.getsockname()[1]), *shop)
    assert Code.SRV_ADDRESS in refused.stderr and list(tmp_path.iterdir()) == []
