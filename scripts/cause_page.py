"""Writes docs/causes.md, the page of all causes, from the catalogue: python -m scripts.cause_page."""

from pathlib import Path
from typing import Final

from trueloop.diagnosis.causes.catalogue import CAUSES
from trueloop.diagnosis.causes.cause import Cause, Over, SeenBy, Sign

PAGE: Final = Path(__file__).parents[1] / "docs" / "causes.md"
HEAD: Final = """# Causes of wrong features

What `trueloop diagnose series` and `trueloop diagnose part` look for. A cause is data: on which errors of features it
shows, to whom, and how it goes over the parts of a series. Probabilities follow from all feature errors of all parts
with their uncertainties; causes that would leave the same share the probability, and the answer says which measurement
would tell them apart. Errors are positive where material is left on. Sections are those of NISTIR 4773; a cause without
one is our own.

The machine's own probe, corrected by the model of the machine, sees what the process did. A measuring machine (CMM) or
a gauge sees what the machine did too. The share is how common a cause is beforehand, beside the others.
"""
SEEN: Final = {
    (SeenBy.MACHINE, SeenBy.CMM): "both",
    (SeenBy.MACHINE,): "the machine's probe",
    (SeenBy.CMM,): "CMM",
    (): "no touch probe",
}
GOES: Final = {
    Over.CONSTANT: "the same on all parts",
    Over.SETTING: "the same until the tool is set anew",
    Over.WEAR: "grows with the minutes in cut",
    Over.TEMPERATURE: "follows a temperature",
    Over.DEPTH: "in proportion to the depth of cut",
    Over.SCATTER: "another one on every part",
    Over.STEP: "begins at some part",
}


def page() -> str:
    """The page as it has to be: a chapter a cause, in the catalogue's order."""
    return HEAD + "".join(_chapter(cause) for cause in CAUSES)


def _chapter(cause: Cause) -> str:
    rows = "".join(_row(sign) for sign in cause.signs)
    section = "" if cause.section == "-" else f" [4773 §{cause.section.replace(', ', ', §')}]"
    standard = "A standard part shows it too, on which nothing was cut.\n\n" if cause.on_standard_part else ""
    return (
        f"\n## {cause.name[0].upper()}{cause.name[1:]}\n\n`{cause.key}`, share {cause.prior:g}\n\n"
        f"| error | seen by | over the parts | features |\n|---|---|---|---|\n{rows}\n{standard}"
        f"Remedy: {cause.remedy}{section}\n\nDecided by: {cause.decided_by}\n"
    )


def _row(sign: Sign) -> str:
    kind = str(sign.kind) if sign.needed else f"{sign.kind} (may)"
    over = ", or ".join(GOES[over] for over in sign.over)
    return f"| {kind} | {SEEN[sign.seen_by]} | {over} | {'one size' if sign.alike else 'each its own'} |\n"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
