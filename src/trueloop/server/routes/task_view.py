"""A task as it is shown."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from trueloop.factory.tasks import Task


@dataclass(frozen=True)
class TaskView:
    """`state`: waiting, running, done, failed; `progress` 0 to 1; `problem`: code, message and hint of a refusal."""

    id: int
    kind: str
    subject: str
    state: str
    progress: float
    said: str
    problem: Mapping[str, Any] | None
    result: Mapping[str, str] | None


def task_view(task: Task) -> TaskView:
    """Without what only workers need."""
    return TaskView(task.id, task.kind, task.subject, task.state, task.progress, task.said, task.problem, task.result)
