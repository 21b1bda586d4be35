"""The service as a process, and people who use it: over HTTP, as their pages do."""

import itertools
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import httpx2

from scripts.factory_demo.parts import PROBE, PartKind

PASSWORD: Final = "four words, none alike"
STAFF: Final = {"otto": "operator", "ana": "engineer", "ada": "admin"}
MACHINE: Final = "lathe 1"
COMMAND: Final = (sys.executable, "-c", "from trueloop.cli.main import main; main()")
ROUTE: Final = ("semifinish", "probe", "correct", "finish", "remove", "measure", "release")
RELEASE: Final = ROUTE.index("release")
REMOVE: Final = ROUTE.index("remove")
WAIT_S: Final = 30.0
READINGS: Final = 5
"""How often somebody reads an order again that the lathe's cell has changed meanwhile."""

CHANGED_MEANWHILE: Final = 412
_NUMBERS: Final = itertools.count()


def trueloop(*words: str, said: str = "") -> str:
    """A command; what it prints."""
    done = subprocess.run([*COMMAND, *words], input=said, capture_output=True, text=True, check=False, timeout=WAIT_S)
    assert done.returncode == 0, f"trueloop {' '.join(words)}: {done.stderr}"
    return done.stdout.strip()


def founded(folder: Path) -> str:
    """A store with accounts, a tool in its holder, and the lathe's key."""
    db = ("--db", str(folder / "trueloop.db"))
    trueloop("db", "init", db[1])
    for name, role in STAFF.items():
        trueloop("user", "add", name, "--role", role, "--password-stdin", *db, said=PASSWORD)
    insert = ("--holder", "SVJBR 2020", "--insert", "VBMT 160408", "--corner", "1", "--nose-radius-mm", "0.8")
    trueloop("tool", "mount", "T1", *insert, *db)
    return trueloop("key", "add", "cell 1", "--machine", MACHINE, *db).split()[-1]


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """The service; its address."""
    command = [*COMMAND, "serve", "--port", "0", "--db", str(folder / "trueloop.db")]
    with (folder / "service.log").open("w") as log:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, text=True)
    try:
        assert process.stdout is not None
        said = process.stdout.readline().split()
        assert said, f"the service does not start, see {folder / 'service.log'}"
        yield said[-1].rstrip("/")
    finally:
        process.terminate()
        process.wait(WAIT_S)


class Person:
    """Somebody of the staff, signed in."""

    def __init__(self, address: str, name: str, transport: httpx2.BaseTransport | None = None) -> None:
        base, own = f"{address}/api/v1", {"Origin": address}
        self._http = httpx2.Client(base_url=base, headers=own, timeout=WAIT_S, transport=transport)
        self.post("/session", {"name": name, "password": PASSWORD})

    def get(self, path: str) -> Any:
        """What stands there."""
        return self._answer(self._http.get(path))

    def post(self, path: str, body: object) -> Any:
        """A change."""
        return self._answer(self._http.post(path, json=body, headers=_numbered()))

    def hand_over(self, name: str, content: bytes) -> str:
        """A file; its hash."""
        answer = self._http.post("/uploads", params={"name": name}, content=content, headers=_numbered())
        return str(self._answer(answer)["sha256"])

    def record(self, order: str, part: int, step: int, why: str) -> None:
        """Records a step done by hand. Reads the order again where it has changed since it was read (FAC-STALE)."""
        path, body = f"/orders/{order}/parts/{part}/record", {"step": step, "why": why}
        for _ in range(READINGS):
            etag = self._http.get(f"/orders/{order}").headers["etag"]
            answer = self._http.post(path, json=body, headers=_numbered() | {"If-Match": etag})
            if answer.status_code != CHANGED_MEANWHILE:
                break
        self._answer(answer)

    def page(self, path: str) -> str:
        """A page as text."""
        return self._http.get(path).text

    def _answer(self, answer: httpx2.Response) -> Any:
        assert answer.status_code < 300, f"{answer.url.path}: {answer.text}"
        return answer.json()


def _numbered() -> dict[str, str]:
    return {"Idempotency-Key": f"demo-{next(_NUMBERS)}"}


def programs(ana: Person, kind: PartKind) -> dict[str, str]:
    """Its programs, handed over, kept and released: their hashes by the kind of the step."""
    found = {}
    for step, text in kind.programs.items():
        name = f"{kind.name}-{step}-{len(kind.plan.touches)}" if step == "probe" else f"{kind.name}-{step}"
        sha = ana.hand_over(f"{name.lower()}.ngc", text)
        ana.post(f"/uploads/{sha}/program", {"dialect": "linuxcnc"})
        ana.post(f"/programs/{sha}/release", {"why": "ran in"})
        found[step] = sha
    return found


def ordered(ana: Person, kind: PartKind, serials: list[str]) -> str:
    """An order for parts; its number."""
    sha = programs(ana, kind)
    blocks = [
        {"kind": one, "program_sha256": sha.get(one, ""), "feature": "", "corrected": one == "finish"} for one in ROUTE
    ]
    plan = {"part_type": kind.name, "revision": "", "machine": MACHINE, "serials": serials, "blocks": blocks}
    return str(ana.post("/orders", plan | {"job_toml": kind.job, "probe_toml": PROBE})["row"]["id"])
