"""Whether one edge cuts in two set-ups: a number may be another tool on another day, and only a name says that it is
the same one.
"""

from itertools import combinations

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.jobs.tool_tables import ToolsTable
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.part import EdgeCorrection, PartCorrection, SetupCorrection
from trueloop.nc.program.called import Called


def require_edges_named(files: JobFiles, corrected: PartCorrection) -> None:
    """Raises SET-EDGE where edges of two set-ups are one for the store, and the job does not state `name` of both:
    what one teaches would be taken for the other's.
    """
    tables = {(setup.name, tool.called): tool for setup in files.job.setups for tool in setup.tools}
    for (one, edge), (other, same) in combinations(_edges(corrected), 2):
        if one is other or _identity(edge) != _identity(same):
            continue
        named = [tables[of.frame.name, called] for of, called in ((one, _called(edge)), (other, _called(same)))]
        if not all(table.name for table in named):
            raise _unnamed(files, (one, other), named)


def _edges(corrected: PartCorrection) -> list[tuple[SetupCorrection, EdgeCorrection]]:
    """Those that the store would have."""
    return [(one, edge) for one in corrected.setups for edge in one.edges if _identity(edge) is not None]


def _called(of: EdgeCorrection) -> Called:
    assert of.contour is not None  # an edge of a set-up has its own
    return of.contour.edge.called


def _identity(of: EdgeCorrection) -> tuple[str, ...] | None:
    edge = None if of.inputs is None else of.inputs.edge
    return None if edge is None else edge.identity


def _unnamed(
    files: JobFiles, setups: tuple[SetupCorrection, SetupCorrection], tools: list[ToolsTable]
) -> TrueloopError:
    names = [one.frame.name for one in setups]
    called = " and ".join(dict.fromkeys(tool.called.words for tool in tools))
    return TrueloopError(
        Code.SET_EDGE,
        f"{called} of set-ups {names[0]} and {names[1]} would be one edge in the store, and the job does not name it",
        hint="state `name` of both tables [[setups.tools]]: the same where it is one tool, else two",
        override="--no-store",
        place=Place(str(files.path)),
        values={"setups": names, "tool": called},
    )
