"""What a job gets out of the store before it is corrected: the parts that its edge has cut before."""

from dataclasses import replace

from trueloop.jobs.store.history import history_from, life_of
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.made_parts import name_of
from trueloop.storage.store import Store
from trueloop.wording import wording


def with_history(store: Store, inputs: Inputs) -> Inputs:
    """Returns the job with the parts of its edge that were cut before its own; unchanged where no edge is stated.

    A job that is run again for a part long finished gets what was known then, and gives the same again. Raises STO
    errors.
    """
    if inputs.edge is None or inputs.memory.memory == "off":
        return inputs
    serials = [one.part.serial for one in inputs.inspections if one.part.serial]
    own = (name_of(inputs.part), serials[0] if serials else "")
    edge = inputs.edge
    every = life_of(store, edge)
    life = [one for one in every if one.of_machine == (inputs.machine is not None)]
    inputs = replace(inputs, notes=(*inputs.notes, *_left_out(len(every) - len(life), inputs.machine is not None)))
    parts = history_from(store, edge, life)
    before = next((k for k, part in enumerate(parts) if (part.part_type, part.serial) == own), len(parts))
    if not before:
        first = wording("First part of this edge: corrected by the fit of its own touches.")
        return replace(inputs, notes=(*inputs.notes, first))
    return replace(inputs, history=parts[:before])


def _left_out(count: int, of_machine: bool) -> tuple[str, ...]:
    if not count:
        return ()
    if of_machine:
        return (
            wording(
                "Parts of this edge corrected without the machine's known errors: {count}. Their errors contain these.",
                count=count,
            ),
        )
    return (
        wording(
            "Parts of this edge corrected for known errors of the machine: {count}. Today's touches contain these.",
            count=count,
        ),
    )
