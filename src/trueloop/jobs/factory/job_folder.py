"""An order's job as a file in a folder of its own, with what it names beside it; nothing of it is left afterwards."""

import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from trueloop.domain.factory import BlockKind, WorkOrder
from trueloop.errors import Code, TrueloopError
from trueloop.factory.load import StoreReader, program_text
from trueloop.formats.measurements.touches_csv import touches_to_csv
from trueloop.jobs.measure.probing import read_logged_touches, read_probing
from trueloop.wording import changed


def programs_of(reader: StoreReader, order: WorkOrder) -> dict[str, bytes]:
    """Returns the texts of an order's semi-finish program and of the finish program to be corrected, by their kinds."""
    blocks = {
        block.kind: block for block in order.route.blocks if block.corrected or block.kind is BlockKind.SEMIFINISH
    }
    return {kind.value: program_text(reader, block.program_sha256) or b"" for kind, block in blocks.items()}


@contextmanager
def job_folder(order: WorkOrder, programs: Mapping[str, bytes], touches: bytes | None = None) -> Iterator[Path]:
    """Yields the path of the order's job, while programs and touches stand beside it as the job calls them.

    Raises FAC-PLAN for names that lead to another folder. What is refused meanwhile names no folder of the service.
    """
    with unnamed_folder() as folder:
        job = folder / "job.toml"
        job.write_text(order.route.job_toml, encoding="utf-8")
        for file, content in _files(order, programs, touches):
            (folder / file).write_bytes(content)
        if order.route.probe_toml and touches is not None:
            # Converts the control's log to touches and puts these in its place. Raises PRB errors.
            probing = read_probing(job)
            log = job.parent / tomllib.loads(job.read_text(encoding="utf-8"))["gauging"]["touches"]
            log.write_text(
                touches_to_csv(read_logged_touches(probing, log, order.route.probe_control).touches), encoding="utf-8"
            )
        yield job


@contextmanager
def unnamed_folder() -> Iterator[Path]:
    """Yields a temporary folder; what is refused meanwhile does not name it."""
    with tempfile.TemporaryDirectory() as name:
        try:
            yield Path(name)
        except TrueloopError as refused:
            raise without_folder(refused, Path(name)) from refused


def without_folder(refused: TrueloopError, path: Path) -> TrueloopError:
    """Returns the refusal with files of that folder by their names alone."""
    folder = f"{path}/"
    place = replace(refused.place, file=(refused.place.file or "").replace(folder, "") or None)
    return refused.code.refusal(
        changed(refused.message, lambda text: text.replace(folder, "")),
        hint=changed(refused.hint, lambda text: text.replace(folder, "")),
        place=place,
        override=refused.override,
        values=refused.values,
    )


def _files(order: WorkOrder, programs: Mapping[str, bytes], touches: bytes | None) -> Iterator[tuple[str, bytes]]:
    """Programs and touches under the names by which the job asks for them, which lead to no other folder."""
    job: dict[str, Any] = tomllib.loads(order.route.job_toml)
    gauging, probe = job.get("gauging", {}), order.route.probe_toml
    named = (
        *((job.get("programs", {}).get(kind), content) for kind, content in programs.items()),
        (gauging.get("probe"), probe.encode() if probe else None),
        (gauging.get("touches"), touches),
    )
    for file, content in named:
        if file is None or content is None:
            continue
        if not isinstance(file, str) or Path(file).name != file:
            raise Code.FAC_PLAN.refusal(
                f"the job of order {order.id!r} names the file {file!r}",
                hint="name programs and touches without a folder: the store has their contents",
            )
        yield file, content
