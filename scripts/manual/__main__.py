"""`python -m scripts.manual`: writes the generated pages into docs/ and the site into src/trueloop/manual."""

from scripts import reference
from scripts.manual.contents import ROOT
from scripts.manual.site import PLACE, write

reference.write()
print(f"{write()} files in {PLACE.relative_to(ROOT)}")
