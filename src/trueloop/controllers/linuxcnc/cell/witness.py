"""What programs have logged of a run: `seen`."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Seen:
    """How often a run's program has begun and ended, by its own word."""

    started: int = 0
    ended: int = 0


def seen(log: str, key: str) -> Seen:
    """Counts the starts and ends of one run. A last line without its end is not read: it may be being written."""
    lines = [line.strip() for line in log.splitlines(keepends=True) if line.endswith("\n")]
    return Seen(lines.count(f"{key} started"), lines.count(f"{key} ended"))
