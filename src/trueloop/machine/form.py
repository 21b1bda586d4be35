"""What a model shall consist of, and the model of that form that readings give."""

from dataclasses import dataclass

from trueloop.machine.choice import Choice, Chosen, choose_signals
from trueloop.machine.history import Lag
from trueloop.machine.identify import Identification, identify
from trueloop.machine.model import Machine
from trueloop.machine.observations import Observations
from trueloop.machine.term import Term


@dataclass(frozen=True)
class Form:
    """Error terms, signals made of the past of others, and what terms may choose from."""

    terms: tuple[Term, ...]
    lags: tuple[Lag, ...] = ()
    choices: tuple[Choice, ...] = ()


def fit_form(
    machine: Machine, form: Form, readings: Observations, *, robust: bool = True
) -> tuple[Identification, tuple[Chosen, ...]]:
    """Signals chosen, then everything identified together; raises as `identify`."""
    terms, chosen = choose_signals(machine, form.terms, form.choices, readings, form.lags)
    return identify(machine, terms, readings, robust=robust, lags=form.lags), chosen
