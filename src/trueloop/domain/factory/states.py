"""How far a part and a step of its route have come: `PartState`, `StepState`."""

from enum import StrEnum


class PartState(StrEnum):
    """Of a part; each but `HELD` follows from the last step that was recorded."""

    PLANNED = "planned"
    ROUGHED = "roughed"
    SEMIFINISHED = "semifinished"
    PROBED = "probed"
    CORRECTED = "corrected"
    FINISHED = "finished"
    INSPECTED = "inspected"  # probed on the machine after its finish cut
    REMOVED = "removed"
    MEASURED = "measured"  # on a measuring machine
    RELEASED = "released"
    REJECTED = "rejected"
    HELD = "held"  # a person decides what happens next


class StepState(StrEnum):
    """Of a step: `STARTED` without an end becomes `UNKNOWN`, and never goes back to `WAITING` by itself."""

    WAITING = "waiting"
    OFFERED = "offered"  # a cell client has asked for it
    SENT = "sent"
    VERIFIED = "verified"  # what the control holds was read back and equals what was sent
    STARTED = "started"
    ENDED = "ended"
    RECORDED = "recorded"  # its data are in the store
    UNKNOWN = "unknown"  # whether the cut was made, or how far, nobody knows
    FAILED = "failed"  # surely not made: it may be tried again


class FactKind(StrEnum):
    """What a witness says of a run."""

    SENT = "sent"
    VERIFIED = "verified"
    STARTED = "started"
    ENDED = "ended"
    RECORDED = "recorded"
    FAILED = "failed"
    UNKNOWN = "unknown"
