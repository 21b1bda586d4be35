"""The command line started from HAL, which has no words with a blank in them, as the program's folder may have."""

import shlex
import sys
from pathlib import Path
from typing import Final

STARTER: Final = {"trueloop.sh": f'exec {shlex.quote(str(Path(sys.executable).with_name("trueloop")))} "$@"\n'.encode()}
"""A file of the session."""

STARTED: Final = "sh trueloop.sh"
"""What starts it, in the session's folder."""
