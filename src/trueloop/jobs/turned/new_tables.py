"""The tool tables of a job of several edges, with the offsets of all edges that are corrected so."""

from collections.abc import Iterable
from pathlib import Path

from trueloop.formats.jobs.tool_tables import ToolsTable
from trueloop.formats.tables.tool_tables.known import new_table, tool_table_of
from trueloop.formats.tables.tool_tables.tool_table import ToolTable
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.joint import Joint, OfEdge


def new_tables(made: Iterable[tuple[JobFiles, Joint]]) -> list[tuple[str, bytes | None]]:
    """File names and contents: of every table that the job's tools name `new-NAME`, None where no offset of it changes.

    `made` are the programs of the job, one or that of each set-up. Edges that stand in one table are written into it
    one after the other. Raises OFS errors.
    """
    found: dict[Path, bytes | None] = {}
    for files, joint in made:
        tables = {tool.called: tool for tool in files.job.tools}
        for one in joint.edges:
            tool = tables[one.contour.edge.called]
            if tool.table is not None:
                found[tool.table] = _with_offset(files.with_tool(tool), tool, tool.table, one, found.get(tool.table))
    return [(f"new-{path.name}", content) for path, content in found.items()]


def _with_offset(files: JobFiles, tool: ToolsTable, path: Path, one: OfEdge, before: bytes | None) -> bytes | None:
    """The table with one edge's offset more; `before`: with those of others."""
    offset = None if one.correction is None else one.correction.record.tool_offset
    if one.correction is None or offset is None or not offset.makes_the_correction:
        return before
    return new_table(_read(files, tool, path, before), offset, one.correction.record.id).content


def _read(files: JobFiles, tool: ToolsTable, path: Path, before: bytes | None) -> ToolTable:
    given = files.tool_table(path)
    return given if before is None else tool_table_of(given.path, before, tool.table_unit)
