"""Whether two checkouts give the same outputs, byte for byte: for changes that are to change none.

    python -m scripts.same_outputs BEFORE AFTER [--corpus DIR]

BEFORE and AFTER are folders of checkouts that were set up (`make setup`). Every example and every program of the tests,
with --corpus every real program too, goes through the commands in both; exit status, words on both streams and files
are compared, except for the date and the hash of a record that holds it.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final, NamedTuple

WHEN: Final = re.compile(
    rb"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d)?(\.\d+)?([+-]\d\d:\d\d|Z)?"
    rb"|15H\d{8}\.\d{6}"  # of an IGES file
    rb'|(?<="content_sha256": ")[0-9a-f]{64}'
)
SECONDS: Final = 300


class Outcome(NamedTuple):
    """What a command left."""

    status: int
    stdout: bytes
    stderr: bytes
    files: dict[str, bytes]


def commands(checkout: Path, corpus: Path | None) -> Iterator[tuple[str, ...]]:
    """The command lines, for a copy of the checkout's examples as the working folder."""
    for job in sorted((checkout / "examples").glob("*/job.toml")):
        name = f"examples/{job.parent.name}/job.toml"
        yield "compensate", name, "-o", "made"
        yield "compensate", name, "-o", "made", "--json"
        yield "part", "show", name
    yield "simulate", "examples/loop/modbas2.toml", "-o", "made"
    for form in ("plan", "program"):
        yield "probe", form, "examples/loop/modbas2.toml"
    for form in ("deviations", "model", "pattern", "compensate"):
        yield "surface", form, "examples/surface/surface.toml", "-o", "made"
    for case in sorted((checkout / "tests" / "programs").glob("*/case.toml")):
        (program,) = case.parent.glob("program.*")
        yield from of_program(program, tomllib.loads(case.read_text())["dialect"])
    for program in sorted((corpus / "data" / "public" / "nc").glob("*.*")) if corpus else ():
        yield from of_program(program, None)


def of_program(program: Path, dialect: str | None) -> Iterator[tuple[str, ...]]:
    """What is done with every program."""
    known = ("-d", dialect) if dialect else ()
    for form in ("check", "path"):
        yield "nc", form, str(program), *known
    yield "nc", "map", str(program), *known, "--shift", "0.01,0,0.01", "-o", "mapped.nc"


def outcome(checkout: Path, command: tuple[str, ...]) -> Outcome:
    """Runs one command in a folder of its own."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copytree(checkout / "examples", folder / "examples")
        before = set(folder.rglob("*"))
        done = subprocess.run(
            [checkout / ".venv" / "bin" / "trueloop", *command],
            cwd=folder, capture_output=True, timeout=SECONDS, check=False,
        )  # fmt: skip
        made = sorted(path for path in set(folder.rglob("*")) - before if path.is_file())
        files = {str(path.relative_to(folder)): lasting(path.read_bytes()) for path in made}
        return Outcome(done.returncode, lasting(done.stdout), lasting(done.stderr), files)


def lasting(content: bytes) -> bytes:
    """A file or a stream without what differs from run to run."""
    return WHEN.sub(b"WHEN", content)


def differences(command: tuple[str, ...], before: Outcome, after: Outcome) -> Iterator[str]:
    """In which of status, streams and files two outcomes differ."""
    for field in ("status", "stdout", "stderr"):
        if getattr(before, field) != getattr(after, field):
            yield f"{' '.join(command)}: {field}"
    for file in sorted(before.files.keys() | after.files.keys()):
        if before.files.get(file) != after.files.get(file):
            yield f"{' '.join(command)}: {file}"


def main() -> int:
    """Prints each difference; 0 when there is none."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    for side in ("before", "after"):
        parser.add_argument(side, type=lambda text: Path(text).resolve())
    parser.add_argument("--corpus", type=lambda text: Path(text).resolve())
    given = parser.parse_args()
    # Both run on the programs of one checkout: what is compared is the code.
    lines = list(commands(given.before, given.corpus))
    with ThreadPoolExecutor(2) as pool:
        pairs = pool.map(lambda line: (outcome(given.before, line), outcome(given.after, line)), lines)
        found = [words for line, pair in zip(lines, pairs, strict=True) for words in differences(line, *pair)]
    print("\n".join(found) or f"{len(lines)} commands: the same")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
