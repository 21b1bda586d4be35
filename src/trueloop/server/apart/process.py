"""The process that reads files: `python -m trueloop.server.apart.process`. It knows no store and no key.

It reads questions from its standard input and writes answers to its standard output, until the service closes the one
or ends it. Whatever its limits do to it, the service does not have to bear.
"""

import math
import os
import sys
import tempfile
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.errors import TrueloopError
from trueloop.jobs.factory.imports import READINGS
from trueloop.server.apart.reading import CODEC, Answer, Question, Refusal

READY: Final = b"ready\n"
"""Its first line, when everything is imported."""
LATER: Final = ("ezdxf.filemanagement", "ezdxf.path", "python_calamine", "charset_normalizer")
"""Modules that readers import when needed, whose memory must not count as that of a file."""


def main() -> None:
    """Answers until there are no more questions. What libraries print goes to stderr, among no answers."""
    with os.fdopen(os.dup(1), "wb") as answers:
        os.dup2(2, 1)
        for name in LATER:
            import_module(name)
        np.linalg.inv(
            np.eye(200)
        )  # BLAS takes its buffer with the first product, and ends the process where it gets none
        begun_with = data_bytes()
        answers.write(READY)
        answers.flush()
        for line in sys.stdin.buffer:
            question = CODEC.from_json(line, Question)
            try:
                with _limited(question, begun_with):
                    answer = _answer(question)
            except MemoryError:  # none was left for the answer itself
                answer = Answer(exhausted=True)
            answers.write(_written(answer, data_bytes() - begun_with))
            answers.flush()


def data_bytes() -> int:
    """Returns the memory of this process that RLIMIT_DATA counts; 0 where the system does not state it."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[5])
    except OSError:
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")


def _answer(question: Question) -> Answer:
    try:
        return Answer(READINGS[question.reading](question.handed))
    except TrueloopError as refused:
        return Answer(refusal=Refusal.of(refused))
    except Exception as fault:  # the service tells of it under a number, as of its own faults
        if any(isinstance(cause, MemoryError) for cause in _causes(fault)):
            return Answer(exhausted=True)
        places = traceback.extract_tb(fault.__traceback__)[-4:]
        where = ", ".join(f"{place.filename.rpartition('/')[2]}:{place.lineno}" for place in places)
        return Answer(fault=f"{type(fault).__name__}: {fault} at {where}")


def _causes(fault: BaseException | None) -> Iterator[BaseException]:
    """An error, and those while whose handling it came."""
    while fault is not None:
        yield fault
        fault = fault.__cause__ or fault.__context__


def _written(answer: Answer, memory_bytes: int) -> bytes:
    found = Answer(answer.value, answer.refusal, answer.fault, answer.exhausted, memory_bytes=memory_bytes)
    return CODEC.to_json(found).encode()


@contextmanager
def _limited(question: Question, begun_with: int) -> Iterator[None]:
    """Memory as the system counts it; processor time where the service, which looks at the clock, has ended."""
    if sys.platform == "win32":
        yield
        return
    import resource

    used = resource.getrusage(resource.RUSAGE_SELF)
    processors = len(os.sched_getaffinity(0)) if sys.platform == "linux" else 1
    seconds = used.ru_utime + used.ru_stime + 2.0 * processors * question.seconds
    limits = {resource.RLIMIT_CORE: 0, resource.RLIMIT_CPU: math.ceil(seconds)}
    if begun_with:
        limits[resource.RLIMIT_DATA] = begun_with + question.memory_bytes
    before = {one: resource.getrlimit(one) for one in limits}
    tempfile.tempdir = str(question.handed.file.parent)
    try:
        for one, limit in limits.items():
            resource.setrlimit(one, (limit, before[one][1]))
        yield
    finally:
        for one, pair in before.items():
            resource.setrlimit(one, pair)


if __name__ == "__main__":
    main()
