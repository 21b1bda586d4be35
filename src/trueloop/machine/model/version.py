"""Which version of a machine's model this is: its parent, the reason, what parts left out said, who accepted it.

A refined model is offered: it is in force only after somebody has accepted it [4773 §3.4, done by people first].
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Acceptance:
    """Who accepted a version, when (ISO 8601, UTC), and why."""

    who: str
    at: str
    why: str = ""


@dataclass(frozen=True)
class Version:
    """Version `number`, counted from the fitted model, which is 0 and says nothing of versions.

    `parent_sha256` is the hash of the file it was refined from, `errors` are the axis errors whose coefficients
    were guilty, `reason` says why in words, `judged` what parts left out said. `made_at` is ISO 8601, UTC.
    """

    number: int
    parent_sha256: str
    errors: tuple[str, ...]
    reason: str
    judged: str
    made_at: str
    made_by: str = ""
    accepted: Acceptance | None = None
