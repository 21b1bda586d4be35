"""A part's job corrected as the command does it, whatever cuts the part: one tool, several, or several set-ups."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from trueloop.domain.page_options import Language, LengthUnit
from trueloop.errors import Code, TrueloopError
from trueloop.formats.input_file import FilePath
from trueloop.jobs.store.keeping import Keeping
from trueloop.jobs.turned.compensate import compensate_and_keep
from trueloop.jobs.turned.compensate_setups import compensate_setups, has_setups
from trueloop.jobs.turned.several import correct_several, has_several
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.joint import Joint


@dataclass(frozen=True)
class CorrectedEdge:
    """One edge of a part: what calls it (`T5 (left corner)`), the features that it cuts, and its correction.

    `setup` is the name of its set-up, "" where the job has none. `correction` is None where nothing was measured of
    what the edge cuts; its positions are those of the program that the edge cuts by, which the corrections of all of
    its edges share: `correction.name_to_run` names the file that carries them.

    >>> part = trueloop.compensate_part(trueloop.example("grooved/grooved.toml"), "out")
    >>> left = part.edge("T5")
    >>> left.tool, left.features, left.correction.decision.by_offset, left.correction.name_to_run
    ('T5 (left corner)', ('left-wall', 'floor-left'), True, 'corrected.nc')
    """

    tool: str
    features: tuple[str, ...]
    correction: Correction | None
    setup: str = ""


@dataclass(frozen=True)
class CorrectedPart:
    """The corrections of a part by edge, in the job's order, and the files written.

    >>> part = trueloop.compensate_part(trueloop.example("modbas2/job.toml"), "out")
    >>> [(edge.tool, edge.features[-1]) for edge in part.edges], part.files[-1].name
    ([('T1', 'dome')], 'record.json')
    """

    edges: tuple[CorrectedEdge, ...]
    files: tuple[Path, ...]

    def edge(self, tool: str, setup: str = "") -> CorrectedEdge:
        """An edge by what calls it, T5, and by its set-up where several cut with such a tool.

        Raises NC-NO-TOOL where there is none, or several are meant.
        """
        asked = [one for one in self.edges if tool in (one.tool, one.tool.partition(" (")[0])]
        found = [one for one in asked if not setup or one.setup == setup]
        if len(found) != 1:
            raise _not_one(tool, setup, len(found), self.edges)
        return found[0]


def compensate_part(
    job: FilePath,
    output: FilePath | None = None,
    *,
    language: Language | None = None,
    unit: LengthUnit | None = None,
    pdf: bool = False,
) -> CorrectedPart:
    """The corrections of a job by edge, of any number of tools and set-ups, and their files: all of them or none.

    As `trueloop compensate`: `output` is the folder, else that which the job names; `language` and `unit` are of the
    pages, where they are not to be the job's. Raises what reading and correcting refuse, and OUT errors.

    >>> part = trueloop.compensate_part(trueloop.example("two-sides/two-sides.toml"), "out")
    >>> [(edge.setup, edge.tool) for edge in part.edges]
    [('first', 'T1'), ('second', 'T2'), ('second', 'T4')]
    >>> part.edge("T4").correction.wear.words  # of the boring bar; Z as the program of its set-up has it
    'tool 4: wear X −0.0100 (diameter), Z −0.0055 mm'
    """
    keeping = Keeping()
    if has_setups(job):
        done = compensate_setups(job, output, keeping, language=language, unit=unit, pdf=pdf)
        edges = [edge for one in done.corrected.setups for edge in _edges(one.joint, one.frame.name)]
        return CorrectedPart(tuple(edges), tuple(done.files))
    if has_several(job):
        several = correct_several(job, output, keeping, language=language, unit=unit, pdf=pdf)
        return CorrectedPart(tuple(_edges(several.joint)), tuple(several.files))
    one = compensate_and_keep(job, output, keeping, language=language, unit=unit, pdf=pdf)
    names = one.correction.profile.names
    return CorrectedPart((CorrectedEdge(one.correction.wear.called, names, one.correction),), tuple(one.files))


def _edges(joint: Joint, setup: str = "") -> Iterator[CorrectedEdge]:
    for of in joint.edges:
        yield CorrectedEdge(of.tool, of.contour.profile.names, of.correction, setup)


def _not_one(tool: str, setup: str, count: int, edges: Sequence[CorrectedEdge]) -> TrueloopError:
    there = ", ".join(f"{one.tool} in {one.setup!r}" if one.setup else one.tool for one in edges)
    where = f" in set-up {setup!r}" if setup else ""
    return TrueloopError(
        Code.NC_NO_TOOL,
        f"{count} edges of the part are {tool!r}{where}; its edges are {there}",
        hint="name the tool as it is called, and its set-up where several cut with it",
        values={"tool": tool},
    )
