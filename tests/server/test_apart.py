"""Files that loop, that take memory, whose process is killed: an answer each; everybody else is served meanwhile."""

import asyncio
import signal
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from hashlib import sha256
from os import getpid, kill
from pathlib import Path
from typing import TypeAlias

import pytest
from httpx2 import Response

from tests.support.awaited import awaited
from tests.support.service import Caller, Running, problem, started
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.factory.uploads import ReadingOptions, Upload, upload_view
from trueloop.jobs.store.codec import store_codec
from trueloop.server.apart.reading import AT_ONCE, PROCESSES, read_apart
from trueloop.server.settings import Limits, Settings
from trueloop.storage.store import open_store

Starts: TypeAlias = Callable[[Limits], Running]
FOREVER = b"G21 G90\n#1=1\n#2=1\no100 while [1]\n#1=[#2" + b"+sin[#1]" * 200 + b"]\n#2=[#2+1]\no100 endwhile\nM2\n"
"""Three million blocks are run of it before it is refused: its state never comes back."""
SMALL = b"G21 G90\no1 if [1]\nG1 X1 F1\no1 endif\nM2\n"


def lines_of_a_drawing(count: int) -> bytes:
    """A drawing of so many lines, of which every second meets the one before."""
    entity = "0\nLINE\n8\n0\n10\n{0}\n20\n{1}\n11\n{2}\n21\n{3}\n"
    lines = (entity.format(k, k % 7, k + 1, (k + 1) % 7 + k % 2) for k in range(count))
    head = "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
    return (head + "".join(lines) + "0\nENDSEC\n0\nEOF\n").encode()


@pytest.fixture
def limited(tmp_path: Path) -> Iterator[Starts]:
    """Starts a service whose files have these limits."""
    store = open_store(str(tmp_path / "trueloop.db"), create=True, codec=store_codec())
    yield lambda limits: started(store, Settings(poll_s=0.01, workers=0, limits=limits))
    store.close()


def sent(caller: Caller, name: str, content: bytes) -> Response:
    return caller.ask("POST", "uploads", params={"name": name}, content=content)


def readers() -> set[int]:
    """The processes that read files for this one, as the system lists them."""
    found = set()
    for children in Path(f"/proc/{getpid()}/task").glob("*/children"):
        with suppress(FileNotFoundError):  # of a thread or process that has ended since it was listed
            for pid in map(int, children.read_text(encoding="ascii").split()):
                if b"trueloop.server.apart.process" in Path(f"/proc/{pid}/cmdline").read_bytes():
                    found.add(pid)
    return found


@pytest.fixture(scope="module", autouse=True)
def none_is_left() -> Iterator[None]:
    """Processes serve one test after the other; whoever ends them leaves none."""
    yield
    PROCESSES.end()
    assert not readers()


def still_reads(caller: Caller) -> None:
    answer = sent(caller, "small.nc", SMALL)
    assert answer.status_code == 201 and answer.json()["program"]["blocks"] == 5, answer.text


def has_ended(pid: int) -> bool:
    """Whether a process is gone, or waits to be told of: one that is about to end has no command line any more."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(") ")[2][0] in "ZX"
    except FileNotFoundError:
        return True


def reader_of(caller: Caller) -> int:
    """The process that reads the next file: the one that has read a small one."""
    before = {pid: ticks_of(pid) for pid in readers()}
    for _ in range(100):
        still_reads(caller)
        after = {pid: ticks_of(pid) for pid in readers()}
        if worked := [pid for pid, ticks in after.items() if ticks > before.get(pid, 0)]:
            (found,) = worked
            return found
    raise AssertionError("no process has worked")


def ticks_of(pid: int) -> int:
    """Processor time that a process has used, in hundredths of a second."""
    return int(Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[11])


def at_work(pid: int) -> int:
    """The same process, when it reads a file."""
    begun, until = ticks_of(pid), time.monotonic() + 60.0
    while ticks_of(pid) < begun + 20:
        assert time.monotonic() < until
        time.sleep(0.02)
    return pid


def test_a_file_that_loops_is_refused(limited: Starts) -> None:
    otto = limited(Limits(read_s=0.5)).signed_in("operator")
    answer = sent(otto, "forever.ngc", FOREVER)
    assert (answer.status_code, problem(answer)) == (422, "SRV-FILE"), answer.text
    assert "longer than 0.5 s" in answer.json()["detail"]


def test_a_file_that_takes_memory_is_refused_and_the_next_one_read(limited: Starts) -> None:
    otto = limited(Limits(read_bytes=32 << 20)).signed_in("operator")
    answer = sent(otto, "large.dxf", lines_of_a_drawing(20_000))
    assert (answer.status_code, problem(answer)) == (422, "SRV-FILE"), answer.text
    assert "memory" in answer.json()["detail"] or "SIG" in answer.json()["detail"]
    still_reads(otto)


@pytest.mark.parametrize(
    ("job", "said"),
    [("a = " + "[" * 5_000, "nested too deeply"), (".".join(["a"] * 50_000) + " = 1", "longer than 0.5 s")],
)
def test_the_job_of_an_order_that_takes_long_is_refused(limited: Starts, job: str, said: str) -> None:
    ana = limited(Limits(read_s=0.5)).signed_in("engineer")
    order = {"part_type": "a", "revision": "", "machine": "m", "serials": ["1"], "blocks": [], "job_toml": job}
    answer = ana.post("orders", order)
    assert (answer.status_code, problem(answer)) == (422, "SRV-FILE"), answer.text
    assert said in answer.json()["detail"]


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSEGV])
def test_a_process_that_is_killed_is_an_answer(limited: Starts, number: signal.Signals) -> None:
    otto = limited(Limits(read_s=100.0)).signed_in("operator")
    reader = reader_of(otto)
    with ThreadPoolExecutor(1) as other:
        answered = other.submit(sent, otto, "forever.ngc", FOREVER)
        kill(at_work(reader), number)
        answer = answered.result(60.0)
    assert (answer.status_code, problem(answer)) == (422, "SRV-FILE"), answer.text
    assert number.name in answer.json()["detail"]
    still_reads(otto)


def test_others_are_served_while_files_loop(limited: Starts) -> None:
    service = limited(Limits(read_s=100.0))
    otto, ana = service.signed_in("operator"), service.signed_in("engineer")
    reader = reader_of(otto)
    with ThreadPoolExecutor(1) as other:
        answered = other.submit(sent, otto, "forever.ngc", FOREVER)
        at_work(reader)
        assert ana.get("orders").status_code == 200
        still_reads(ana)
        assert not answered.done()
        kill(reader, signal.SIGKILL)
        assert problem(answered.result(60.0)) == "SRV-FILE"


def test_more_than_some_do_not_wait(limited: Starts, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trueloop.server.apart.reading.WAITING", 1)
    here = limited(Limits(read_s=0.5)).app.state.service
    upload = Upload("forever.ngc", sha256(FOREVER).hexdigest(), FOREVER)

    async def at_once(count: int) -> list[object]:
        many = [read_apart(here, upload, ReadingOptions(), upload_view) for _ in range(count)]
        return list(await asyncio.gather(*many, return_exceptions=True))

    refused = awaited(at_once(AT_ONCE + 2))
    codes = [one.code for one in refused if isinstance(one, TrueloopError)]
    assert codes == [Code.SRV_FILE] * (AT_ONCE + 1) + [Code.SRV_DELAY]


def test_one_process_reads_one_file_after_the_other(limited: Starts, monkeypatch: pytest.MonkeyPatch) -> None:
    """And gets nothing of what the service knows by its environment."""
    PROCESSES.end()
    monkeypatch.setenv("PGPASSWORD", "four words, none alike")
    otto = limited(Limits()).signed_in("operator")
    first = reader_of(otto)
    assert b"PGPASSWORD" not in Path(f"/proc/{first}/environ").read_bytes()
    assert reader_of(otto) == first
    kill(first, signal.SIGKILL)  # while it waits, as the system does that has no memory left
    until = time.monotonic() + 10.0
    while not has_ended(first) and time.monotonic() < until:
        time.sleep(0.01)
    assert reader_of(otto) != first
