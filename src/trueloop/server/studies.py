"""What was worked out of the store, until a fact comes that it may depend on: nothing is worked out twice."""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from threading import Lock
from typing import Any, Final, TypeVar

from sqlalchemy import func, select

from trueloop.storage.store import Store
from trueloop.storage.tables import TABLES

MOST: Final = 64
"""Answers that are kept; the one that was not asked for longest goes first."""
_OF_RUNS: Final = {"run", "run_fact", "work_order"}
"""How far orders have come: it says nothing of how parts are."""
T = TypeVar("T")


def newest_facts(store: Store) -> tuple[int, ...]:
    """Returns the number of the newest fact of each kind: facts are added and never changed."""
    numbers = [select(func.max(table.c.id)).scalar_subquery() for name, table in TABLES.items() if name not in _OF_RUNS]
    with store.reading() as connection:
        return tuple(number or 0 for number in connection.execute(select(*numbers)).one())


@dataclass
class _Answer:
    facts: tuple[int, ...]
    lock: Lock = field(default_factory=Lock)
    done: list[Any] = field(default_factory=list)


class Studies:
    """Answers by what was asked. Who asks while it is being worked out waits for the same answer."""

    def __init__(self) -> None:
        self._answers: OrderedDict[object, _Answer] = OrderedDict()
        self._lock = Lock()

    def of(self, store: Store, asked: object, work_out: Callable[[], T]) -> T:
        """Returns the answer as of the newest facts. A refusal is not kept: the next request tries anew."""
        answer = self._answer(asked, newest_facts(store))
        with answer.lock:
            if not answer.done:
                answer.done.append(work_out())
            found: T = answer.done[0]
            return found

    def _answer(self, asked: object, facts: tuple[int, ...]) -> _Answer:
        with self._lock:
            answer = self._answers.get(asked)
            if answer is None or answer.facts != facts:
                answer = self._answers[asked] = _Answer(facts)
            self._answers.move_to_end(asked)
            while len(self._answers) > MOST:
                self._answers.popitem(last=False)
            return answer
