"""`python -m scripts.manual.drawings`: writes every drawing."""

from scripts.manual.contents import ROOT
from scripts.manual.drawings.all import DRAWINGS

for name, draw in DRAWINGS.items():
    (ROOT / "docs" / "images" / f"{name}.svg").write_text(draw(), encoding="utf-8")
