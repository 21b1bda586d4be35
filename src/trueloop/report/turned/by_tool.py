"""The answer by tool, in words, as JSON and as a block of the page."""

from trueloop.loops.turned.correction import Correction
from trueloop.report.markup import esc
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.turned.program.by_tool import ByTool, MovedFeature
from trueloop.units import UM_PER_MM


def by_tool_lines(correction: Correction) -> list[str]:
    """The answer, what the contour would take out beyond it, and what the offset moves; [] where none comes first."""
    of = correction.by_tool
    return [of.words, of.beyond_words, of.moved_words] if of is not None and of.comes_first else []


def by_tool_block(correction: Correction, say: Texts = ENGLISH) -> str:
    """Returns the offsets by tool for the page (HTML); empty where no offset comes first."""
    lines = [say.note(line) for line in by_tool_lines(correction)]
    if not lines:
        return ""
    answer, *more = (esc(line) for line in lines)
    return f"<p id='by-tool'><strong>{answer}</strong><br>{'<br>'.join(more)}</p>"


def by_tool_as_dict(correction: Correction) -> dict[str, object] | None:
    """Converts the answer to a dict, whether it comes first or not; None where a machine model takes part."""
    of = correction.by_tool
    if of is None:
        return None
    return {
        "words": of.words,
        "comes_first": of.comes_first,
        "tools": [vars(one) for one in of.tools],
        "share": of.share,
        "beyond": _beyond(of),
        "features": [_feature(one) for one in of.features],
    }


def _beyond(of: ByTool) -> dict[str, object]:
    x, z = of.at_mm
    return {"um": of.beyond_mm * UM_PER_MM, "feature": of.beyond_on, "x_radius_mm": x, "z_mm": z}


def _feature(of: MovedFeature) -> dict[str, object]:
    return {
        "feature": of.feature,
        "moved_low_um": of.low_mm * UM_PER_MM,
        "moved_high_um": of.high_mm * UM_PER_MM,
        "own_correction_um": of.own_mm * UM_PER_MM,
        "moved_there_um": of.moved_mm * UM_PER_MM,
        "touched": of.touched,
        "against": of.against,
    }
