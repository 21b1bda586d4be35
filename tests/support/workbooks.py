"""Workbooks written cell by cell, for tests of readers: no library that writes them is needed."""

import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeAlias
from xml.sax.saxutils import escape

Rows: TypeAlias = Sequence[Sequence[object]]
"""Numbers, texts, None for an empty cell; `Raw` for a cell's own XML."""

TYPES = (
    '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">'
    '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    '<Default Extension="xml" ContentType="application/xml"/></Types>'
)
MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
LINKS = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
PACKAGE = "http://schemas.openxmlformats.org/package/2006/relationships"
STYLES = f'<styleSheet xmlns="{MAIN}"><cellXfs><xf numFmtId="0"/><xf numFmtId="22"/></cellXfs></styleSheet>'
"""Style 1 is a date with a time."""
CORE = (
    '<cp:coreProperties xmlns:cp="http://schemas.openxmlformats.org/package/2006/metadata/core-properties"'
    ' xmlns:dc="http://purl.org/dc/elements/1.1/"><dc:creator>{}</dc:creator></cp:coreProperties>'
)


class Raw(str):
    """A cell's attributes and content: `t="e"><v>#REF!</v>`."""


def write_xlsx(
    path: Path, sheets: Mapping[str, Rows], *, merged: Sequence[str] = (), creator: str = "", hidden: Sequence[str] = ()
) -> Path:
    """A workbook of these sheets, `merged` ranges in each, with its author in the properties."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", TYPES)
        archive.writestr("_rels/.rels", _links(("rId1", "officeDocument", "xl/workbook.xml")))
        archive.writestr("docProps/core.xml", CORE.format(creator))
        listed = "".join(
            f'<sheet name="{escape(name)}" sheetId="{k}" r:id="rId{k}"{_state(name, hidden)}/>'
            for k, name in enumerate(sheets, 1)
        )
        archive.writestr(
            "xl/workbook.xml", f'<workbook xmlns="{MAIN}" xmlns:r="{LINKS}"><sheets>{listed}</sheets></workbook>'
        )
        links = [(f"rId{k}", "worksheet", f"worksheets/sheet{k}.xml") for k in range(1, len(sheets) + 1)]
        archive.writestr("xl/_rels/workbook.xml.rels", _links(*links, ("rIdS", "styles", "styles.xml")))
        archive.writestr("xl/styles.xml", STYLES)
        for k, rows in enumerate(sheets.values(), 1):
            archive.writestr(f"xl/worksheets/sheet{k}.xml", _sheet(rows, merged))
    return path


def _state(name: str, hidden: Sequence[str]) -> str:
    return ' state="hidden"' if name in hidden else ""


def _links(*links: tuple[str, str, str]) -> str:
    each = "".join(f'<Relationship Id="{key}" Type="{LINKS}/{kind}" Target="{target}"/>' for key, kind, target in links)
    return f'<Relationships xmlns="{PACKAGE}">{each}</Relationships>'


def _sheet(rows: Rows, merged: Sequence[str]) -> str:
    body = "".join(f'<row r="{k}">{"".join(_cells(k, row))}</row>' for k, row in enumerate(rows, 1) if row)
    ranges = "".join(f'<mergeCell ref="{one}"/>' for one in merged)
    spans = f"<mergeCells>{ranges}</mergeCells>" if merged else ""
    return f'<worksheet xmlns="{MAIN}"><sheetData>{body}</sheetData>{spans}</worksheet>'


def _cells(row: int, values: Sequence[object]) -> list[str]:
    out = []
    for column, value in enumerate(values):
        name = f"{chr(65 + column)}{row}"
        if isinstance(value, Raw):
            out.append(f'<c r="{name}" {value}</c>')
        elif isinstance(value, str):
            out.append(f'<c r="{name}" t="inlineStr"><is><t>{escape(value)}</t></is></c>')
        elif value is not None:
            out.append(f'<c r="{name}"><v>{value}</v></c>')
    return out
