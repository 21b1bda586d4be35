"""`refine`: a machine's model refined, judged on parts left out, with what changed and why in words."""

from collections.abc import Sequence
from dataclasses import dataclass

from trueloop.errors import Code, TrueloopError
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.names import ErrorName
from trueloop.machine.refine.guilty import Guilty
from trueloop.machine.refine.judged import Judged, judged
from trueloop.machine.refine.left import Change, LeftOnParts, changes
from trueloop.machine.refine.update import Updated, guilty_ones, update
from trueloop.wording import Wording, wording


@dataclass(frozen=True)
class Refined:
    """The new model (without a version: `offered` gives it one), the update that made it, and the judgement by parts
    left out.
    """

    model: MachineModel
    guilty: tuple[Guilty, ...]
    updated: Updated
    judged: Judged
    changes: tuple[Change, ...]
    parts: int

    @property
    def reason(self) -> Wording:
        """Returns the reason of the change of the model, in words."""
        named = ", ".join(f"{one.error}" + (f" ({one.signal})" if one.signal else "") for one in self.guilty)
        far_off = int(self.updated.outlier.sum())
        if not named:
            return wording(
                "every error refined within its uncertainty, from what the model left on {parts} parts ({n} points far "
                "off hardly counted)",
                parts=self.parts,
                n=far_off,
            )
        return wording(
            "{errors} refined from what the model left on {parts} parts ({n} points far off hardly counted)",
            errors=named,
            parts=self.parts,
            n=far_off,
        )


def refine(
    model: MachineModel, seen: LeftOnParts, guilty: Sequence[ErrorName | Guilty], *, share: float = 1.0
) -> Refined:
    """Refines the model by its residuals on the parts, and judges it on parts and part types left out.

    `guilty` are the errors that the diagnosis holds wrong, which may move beyond their covariance. `share` is the part
    of the change that is made [4773 §2.5]. Nothing is refused for being no better: check `judged.better`, or
    `require_better`. Raises what `update` does.
    """
    named = guilty_ones(guilty)
    whole = update(model, seen, named, share=share)

    def again(others: LeftOnParts) -> Updated:
        return update(model, others, named, share=share, start=whole.fit)

    found = judged(model, seen, whole, again)
    return Refined(whole.model, named, whole, found, changes(model, whole.model), len(seen.parts))


def require_better(refined: Refined, accepted: Sequence[Code] = ()) -> None:
    """Refuses a refined model that is no better on parts left out (DIA-WORSE), unless that is among the accepted."""
    if refined.judged.better or Code.DIA_WORSE in accepted:
        return
    raise TrueloopError(
        Code.DIA_WORSE,
        f"the refined model is not better: {refined.judged.words}",
        hint="inspect more parts, other part types or with other tools, and ask `trueloop diagnose machine` again",
        override="--accept DIA-WORSE",
    )
