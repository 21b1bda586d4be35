"""The README's picture, made anew: the head of the MODBAS2 example's report and its first figure.

Run from the project's folder: `.venv/bin/python -m scripts.readme_picture`. It needs Chromium.
"""

import tempfile
from pathlib import Path
from typing import Final

from tests.support.chromium import screenshot
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.report.turned.page import page

PICTURE: Final = Path("docs/images/modbas2-report.png")
SIZE_PX: Final = (1040, 1140)
ONLY_HEAD: Final = """<style>
.note, .kicker, .fields, #tolerances, #run, #errors, h2, figcaption { display: none !important; }
.verdict { margin: 10px 0; } main { padding: 14px 20px; } figure { margin: 0; }
</style></head>"""


def main() -> None:
    """Corrects the example and photographs its report."""
    html = page(compensate(read_job(Path("examples/modbas2/job.toml")).inputs))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "report.html"
        file.write_text(html.replace("</head>", ONLY_HEAD, 1), encoding="utf-8")
        PICTURE.parent.mkdir(parents=True, exist_ok=True)
        screenshot(file, PICTURE, *SIZE_PX)


if __name__ == "__main__":
    main()
