"""What cut a measured part: the given program, or one of the ways in which a correction is carried out."""

from dataclasses import dataclass
from typing import Final

from trueloop.domain.life import Ran
from trueloop.wording import wording

XZ = tuple[float, float]


@dataclass(frozen=True)
class CutWith:
    """What cut a part, as stated in the job or in the store; a known input of every estimate of its errors.

    `ran` is the program, or that an offset was entered; `correction` the id of the record, "" where none was in force;
    `program_sha256` the hash of the text that ran, "" where it is not known. `offset_mm` is how far the tool stood off
    the path of that program by offsets (x as a radius, z); `wear_mm` the part of it in the control's wear table: it is
    in force for the next cut too, which a program's own offset is not.
    """

    ran: Ran = Ran.AS_PROGRAMMED
    correction: str = ""
    program_sha256: str = ""
    offset_mm: XZ = (0.0, 0.0)
    wear_mm: XZ = (0.0, 0.0)

    @property
    def corrected(self) -> bool:
        """Returns whether a correction was in force."""
        return bool(self.correction)

    @property
    def words(self) -> str:
        """Returns words such as `correction 319bcb4f5bd4419b (corrected program)`."""
        if not self.corrected:
            return wording("the given program, no correction in force")
        how = {
            Ran.CORRECTED: wording("corrected program"),
            Ran.OFFSETS: wording("program with tool offsets"),
            Ran.WEAR: wording("offset entered at the control"),
            Ran.AS_PROGRAMMED: wording("given program"),
        }[self.ran]
        return wording("correction {id} ({how})", id=self.correction, how=how)

    def still_to_do(self, total_mm: XZ) -> XZ:
        """Returns what of a whole offset is not in the control's wear table yet, mm."""
        return total_mm[0] - self.wear_mm[0], total_mm[1] - self.wear_mm[1]


GIVEN: Final = CutWith()
"""The given program without a correction."""
