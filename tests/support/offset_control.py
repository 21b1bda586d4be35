"""A control's memory of tool offsets, and what a program of its own words makes of it: written apart from the writer.

Fanuc [B-63524EN, p. 285]: G10 P U W adds to wear offset P. Haas: the same under L11. Sinumerik: `$TC_DP12[t,d]` wear of
length 1 (x, a radius), DP13 of length 2 (z). Okuma: VTOFX[n], VTOFZ[n]. GE 2000T [6811]: UPD sets TOV(X), TOV(Z).
"""

import re
from dataclasses import dataclass

SET = re.compile(r"^(\$TC_DP(?:12|13)\[\d+,\d+\]|VTOF[XZ]\[\d+\])=(.+)$")
UPDATE = re.compile(r"^\(UPD, (\d+), TOV\((X|Z)\), ([-+.\d]+)\)$")
WORD = re.compile(r"([A-Z])([-+.\d]+)")


@dataclass
class Memory:
    """The offsets of tools, (x, z) each as the control counts them, in mm; `inch`: it counts inches."""

    offsets: dict[int, list[float]]
    inch: bool = False

    def run(self, program: str) -> None:
        """Every line of a program; one that is not understood fails."""
        for line in program.splitlines():
            self._block(re.sub(r"\(TRUELOOP[^)]*\)|;.*|!.*", "", line).strip())

    def _block(self, block: str) -> None:
        if block in ("", "%", "M30", "M02"):
            return
        if update := UPDATE.match(block):
            self.offsets[int(update[1])]["XZ".index(update[2])] = float(update[3])
        elif assigned := SET.match(block):
            self._assign(assigned[1], assigned[2])
        else:
            self._g10(WORD.findall(block))

    def _assign(self, name: str, formula: str) -> None:
        tool, axis = int(re.findall(r"\[(\d+)", name)[0]), int("DP13" in name or "VTOFZ" in name)
        value = formula.replace(name, repr(self.offsets[tool][axis]))
        terms = re.findall(r"[-+]?[\d.]+(?:e-?\d+)?", value)
        assert "".join(terms) == value, value
        self.offsets[tool][axis] = sum(map(float, terms))

    def _g10(self, words: list[tuple[str, str]]) -> None:
        codes = [value for letter, value in words if letter == "G"]
        found = {letter: value for letter, value in words if letter != "G"}
        assert set(codes) == {"10", "20" if self.inch else "21"} and set(found) <= set("LPUW"), words
        assert found.get("L", "11") == "11"
        for axis, letter in enumerate("UW"):
            assert "." in found[letter], "counts least increments"
            self.offsets[int(found["P"])][axis] += float(found[letter])
