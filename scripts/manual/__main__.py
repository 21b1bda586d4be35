"""`python -m scripts.manual`: writes the site into src/trueloop/manual."""

from scripts.manual.contents import ROOT
from scripts.manual.site import PLACE, write

print(f"{write()} files in {PLACE.relative_to(ROOT)}")
