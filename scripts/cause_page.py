"""Writes docs/causes.md, the page of all causes, from the catalogue: python -m scripts.cause_page."""

from pathlib import Path
from typing import Final

from trueloop.diagnosis.causes.catalogue import CAUSES
from trueloop.diagnosis.causes.cause import Cause, Over, SeenBy, Sign

PAGE: Final = Path(__file__).parents[1] / "docs" / "causes.md"
HEAD: Final = """# Causes of wrong features

The catalogue of `trueloop diagnose series` and `trueloop diagnose part`. For each cause it states on which errors of
features the cause shows, which measurement sees it, and how it varies over the parts of a series. Probabilities are
computed from all feature errors of all parts with their uncertainties. Causes that leave the same errors share the
probability; the result then names the measurement that distinguishes them.

- **Errors** are positive where material is left on. `(may)`: the cause can act without this error.
- **Seen by**: the machine's probe, corrected by the machine's model, sees the errors of the process. A measuring
  machine (CMM) or a gauge also sees those of the machine. "Both": each of the two sees this error.
- **Features**: all features of a tool have one size of the error, or each has its own.
- **Share**: how common the cause is before anything is measured, relative to the others.
- **Sections** are those of NISTIR 4773. A cause without a section is our own.
"""
SEEN: Final = {
    (SeenBy.MACHINE, SeenBy.CMM): "both",
    (SeenBy.MACHINE,): "the machine's probe",
    (SeenBy.CMM,): "CMM",
    (): "no touch probe",
}
GOES: Final = {
    Over.CONSTANT: "equal on all parts",
    Over.SETTING: "equal until the tool is set anew",
    Over.WEAR: "grows with the minutes in cut",
    Over.TEMPERATURE: "follows a temperature",
    Over.DEPTH: "in proportion to the depth of cut",
    Over.SCATTER: "different on every part",
    Over.STEP: "begins at one part",
}


def page() -> str:
    """Returns the page: a chapter for each cause, in the catalogue's order."""
    return HEAD + "".join(_chapter(cause) for cause in CAUSES)


def _chapter(cause: Cause) -> str:
    kinds: dict[str, list[str]] = {}
    for sign in cause.signs:
        kinds.setdefault(_circumstances(sign), []).append(str(sign.kind) if sign.needed else f"{sign.kind} (may)")
    rows = "".join(f"| {', '.join(errors)} | {circumstances} |\n" for circumstances, errors in kinds.items())
    section = "" if cause.section == "-" else f" [4773 §{cause.section.replace(', ', ', §')}]"
    standard = " A standard part, on which nothing was cut, shows it too." if cause.on_standard_part else ""
    return (
        f"\n## {cause.name[0].upper()}{cause.name[1:]}\n\n`{cause.key}`, share {cause.prior:g}.{standard}\n\n"
        f"| error | seen by | over the parts | features |\n|---|---|---|---|\n{rows}\n"
        f"- Remedy: {cause.remedy}{section}\n- Test: {cause.decided_by}\n"
    )


def _circumstances(sign: Sign) -> str:
    over = ", or ".join(GOES[over] for over in sign.over)
    return f"{SEEN[sign.seen_by]} | {over} | {'one size' if sign.alike else 'each its own'}"


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
