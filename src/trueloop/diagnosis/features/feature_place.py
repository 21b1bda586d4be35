"""Where a feature of a turned part lies."""

from dataclasses import dataclass

from trueloop.geometry.feature import Feature


@dataclass(frozen=True)
class FeaturePlace:
    """Where a feature is: `kind` "shaft", "face", "cone" or "arc"; x as a radius and z in the part's frame, mm.

    `z_mm` and `radius_mm` are ranges, low to high. `tool` is the name of the tool that finished it. `shape` is its line
    or arc, by which measured values are matched with it; None: they say themselves which feature they are of.
    """

    name: str
    kind: str
    radius_mm: tuple[float, float]
    z_mm: tuple[float, float]
    tool: str = ""
    shape: Feature | None = None
