"""The kinds of tasks and what does them: `RUNNERS`."""

from collections.abc import Mapping
from typing import Final

from trueloop.factory.tasks import Runner
from trueloop.jobs.factory.correct import correct

RUNNERS: Final[Mapping[str, Runner]] = {"correct": correct}
