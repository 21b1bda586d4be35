"""The jobs, programs and measurements that come with trueloop."""

from pathlib import Path
from typing import Final

EXAMPLES: Final = Path(__file__).parents[1] / "examples"


def example(name: str) -> Path:
    """The path of an example: `name` is that of a file below `examples/`. What reads it refuses one that is not there.

    >>> trueloop.example("modbas2/job.toml").name
    'job.toml'
    """
    return EXAMPLES / name
