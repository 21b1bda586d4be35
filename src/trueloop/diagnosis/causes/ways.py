"""How a cause shows on the surface of parts: fresh copies of terms, wider than in a sound process.

Who sees a cause and how it goes over the parts is in the catalogue; its shape over the surface is here, as basis
functions of the place along the outward normal (n_x, n_z). A cause has several ways where it may show in several; each
is a hypothesis of its own. What a device sees turns with the part: a calibrated part, on which nothing was cut, shows
the part probe as it is and the machine turned round, since a machine that is off by E reads it by −E.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.causes.cause import Cause, Over, SeenBy, SeenSeries, SurfaceErrors
from trueloop.diagnosis.causes.weighing import columns
from trueloop.diagnosis.features.feature_error import ErrorKind
from trueloop.estimate.catalogue import Term
from trueloop.estimate.places import Places

Basis = Callable[[Places], Array]
Form = tuple[tuple[tuple[str, ...], Basis], ...]
"""Coefficients that show together: their scopes (("feature",): each its own) with their basis functions."""

LEAST_STEP: Final = 2
"""Parts on either side of a step."""
SEEN_MM: Final = 0.03
"""A cause that no instrument sees when it is so large is not weighed."""


@dataclass(frozen=True)
class Way:
    """One way in which a cause may show: terms, how over the parts, on features of which tool.

    `signal` is the temperature that it follows ("": the order of the parts), `step` the part from which on it acts,
    `form` the number of its form. `wavy`: waviness, which is not a term of its own.
    """

    cause: Cause
    over: Over
    terms: tuple[Term, ...]
    tool: str = ""
    signal: str = ""
    step: int = 0
    form: int = 0
    wavy: bool = False
    seen_by: tuple[SeenBy, ...] = ()

    @property
    def who(self) -> tuple[str, str]:
        """The cause and the tool: ways of one of these are alternatives to each other."""
        return self.cause.key, self.tool


def ways(cause: Cause, errors: SurfaceErrors, series: SeenSeries) -> Iterator[Way]:
    """All of a cause, for each tool (and all of them), temperature and part that a step could begin at."""
    if any(sign.kind is ErrorKind.WAVINESS and sign.needed for sign in cause.signs):
        yield Way(cause, Over.SCATTER, (), wavy=True, seen_by=cause.signs[0].seen_by)
        return
    tools = dict.fromkeys(tool for (tool,) in errors.places.labels(("tool",)))
    several = sorted(tools) if len(tools) > 1 and cause.of_tool else []
    forms = _forms(cause, errors, len(several) > 1)
    overs = dict.fromkeys(over for sign in cause.signs for over in sign.over)
    for seen_by in dict.fromkeys(sign.seen_by for sign in cause.signs if sign.seen_by):
        for number, form in enumerate(forms):
            for over in overs:
                for tool in [*several, ""]:
                    if tool == "" and several and cause.key == TWO_TOOLS:
                        continue  # the z offsets of all tools alike are where z counts from
                    if over is Over.SCATTER and not _tells_scatter(cause, number, seen_by, len(forms)):
                        continue
                    way = Way(cause, over, (), tool, form=number, seen_by=seen_by)
                    yield from _over(way, form, errors, series)


def block_of(way: Way, errors: SurfaceErrors) -> Array:
    """Returns the effect of its coefficients on the errors, (n, k), the largest of each column 1; k = 0 where it shows
    nowhere.

    Of scatter the largest is 2, so that sizes begin where those of a sound process end.
    """
    found = columns(way.terms, errors.places, unit=True)
    found = found / np.abs(found).max(axis=0) if found.size else found
    unlike = {one.tobytes(): one for one in np.round(found, 9).T + 0.0}
    return (2.0 if way.over is Over.SCATTER else 1.0) * np.column_stack([np.zeros((len(errors), 0)), *unlike.values()])


TWO_TOOLS: Final = "two-tools"


def _x(p: Places) -> Array:
    return p.number("normal_x")[:, None]


def _z(p: Places) -> Array:
    return p.number("normal_z")[:, None]


def _shafts(p: Places) -> Array:
    return (p.number("normal_x") ** 2)[:, None]


def _face(p: Places) -> Array:
    return p.number("face")[:, None]


def _face_z(p: Places) -> Array:
    return _z(p) * _face(p)


def _linear(p: Places) -> Array:
    return _x(p) * p.number("reach")[:, None]


def _cubic(p: Places) -> Array:
    return _x(p) * p.number("reach")[:, None] ** 3


def _along_path(p: Places) -> Array:
    """From the free end, where a pass begins, to the chuck."""
    return 1.0 - p.number("reach")[:, None]


def _faces(degree: int, along: str) -> Basis:
    """Polynomials over faces: along the radius of all faces alike, or along the share of each."""

    def basis(p: Places) -> Array:
        values = p.number(along) / (np.abs(p.number(along)).max(initial=0.0) or 1.0)
        return np.asarray(_face(p) * np.vander(values, degree + 1, increasing=True))

    return basis


def _waves(per_turn: int, along: bool = False) -> Basis:
    """Waves around the turn; `along`: of an amplitude that changes along the feature.

    Fewer than 2n + 1 different angles do not show n waves, and one angle alone would take any radius for one.
    """

    def basis(p: Places) -> Array:
        angle, share = p.number("spindle_rad"), p.number("share")[:, None]
        different = len(np.unique(np.round(angle[~np.isnan(angle)], 4)))
        known = np.where(np.isnan(angle) | (different < 2 * per_turn + 1), 0.0, p.number("normal_x"))
        angle = np.where(np.isnan(angle), 0.0, per_turn * angle)
        waves = np.column_stack([known * np.cos(angle), known * np.sin(angle)])
        return np.hstack([waves, share * waves, share**2 * waves]) if along else waves

    return basis


def _nose(p: Places) -> Array:
    """Polynomials of the contact angle, without what a displacement of the tool leaves: none of two angles alone."""
    normal = np.column_stack([p.number("normal_x"), p.number("normal_z")])
    angle = np.arctan2(normal[:, 0], normal[:, 1]) / np.pi
    forms = np.polynomial.legendre.legvander(angle, 5)
    left = forms - normal @ (np.linalg.pinv(normal) @ forms)
    basis, sizes, _ = np.linalg.svd(left, full_matrices=False)
    return np.asarray(basis[:, sizes > 1e-6 * len(p)])


def _any(p: Places) -> Array:
    share = p.number("share")
    return np.column_stack([np.ones(len(p)), share, share**2])


def _level(p: Places) -> Array:
    return np.ones((len(p), 1))


def _line(p: Places) -> Array:
    return _any(p)[:, :2]


def _axis(normal: str, *along: str) -> Basis:
    """An error of the machine along x or z that grows with positions."""

    def basis(p: Places) -> Array:
        return np.asarray(np.prod([p.number(name) for name in (normal, *along)], axis=0)[:, None])

    return basis


_ALL: Final[tuple[str, ...]] = ()
_EACH: Final = ("feature",)
_X, _Z = "normal_x", "normal_z"
_AXES: Final = (
    _axis(_X), _axis(_X, "x_mm"), _axis(_X, "z_mm"), _axis(_X, "z_mm", "z_mm"), _axis(_Z, "x_mm"),
    _axis(_Z, "z_mm"), _axis(_Z, "x_mm", "x_mm"), _axis(_X, "x_mm", "z_mm"),
)  # fmt: skip
_FORMS: Final[Mapping[str, tuple[Form, ...]]] = {
    "fixturing-part": (((_ALL, _linear),), ((_EACH, _face_z),), ((_ALL, _linear), (_EACH, _face_z))),
    "fixturing-tool-probe": (((_ALL, _x),),),
    "fixturing-part-probe": (((_ALL, _x),),),
    "tool-seat": (((_ALL, _x),), ((_ALL, _x), (_ALL, _z))),
    "tool-setting": (((_ALL, _x),),),
    "tool-wear": (((("tool",), _level),), ((("tool",), _shafts),)),
    "nose-form": (((("tool",), _nose),),),
    "part-probe-offset": (((_ALL, _x),), ((_ALL, _level),)),
    "wear-between": (((_ALL, _along_path),),),
    "part-deflection": (((_ALL, _cubic),),),
    "tailstock": (((_ALL, _linear),),),
    "tool-deflection": (((_ALL, _faces(1, "x_mm")),), ((_EACH, _faces(1, "share")),)),
    "constant-speed": (
        ((_ALL, _faces(1, "x_mm")),),
        ((_ALL, _faces(2, "x_mm")),),
        ((_EACH, _faces(1, "share")),),
        ((_EACH, _faces(2, "share")),),
    ),
    "chuck": (((_ALL, _waves(1)),), ((_EACH, _waves(1)),)),
    "jaws": (((_EACH, _waves(3)),), ((_EACH, _waves(3, along=True)),)),
    "machine": (*(((_ALL, basis),) for basis in _AXES), tuple((_ALL, basis) for basis in _AXES[:6])),
}


def _tells_scatter(cause: Cause, number: int, seen_by: tuple[SeenBy, ...], forms: int) -> bool:
    """Returns whether a form is weighed as another one on every part: with no more coefficients than parts."""
    if cause.key in ("chuck", "jaws"):
        return number == 0
    return cause.key != "other" or (2 * number > forms and len(seen_by) == len(SeenBy))


def _forms(cause: Cause, errors: SurfaceErrors, tools: bool) -> list[Form]:
    if cause.key == "unequal-depth":
        if errors.depths_known:
            return [((_ALL, _usual(_face)),), ((_ALL, _usual(_level)),)]
        return [((_EACH, _level),)]  # any feature may have been cut deeper than the others
    if cause.key == TWO_TOOLS:
        return [((_ALL, _face_z),)] if tools else [((_ALL, _on(faces, _z)),) for faces in _split(errors)]
    if cause.key == "other":
        names = dict.fromkeys(name for (name,) in errors.places.labels(_EACH))
        every = ((_EACH, _level),)
        return [every, *(((_ALL, _on((name,), of)),) for of in (_any, _line) for name in names)]
    if cause.key == "machine" and len(set(errors.places.labels(("tool",)))) > 1:
        return [*_FORMS[cause.key], ((("tool",), _x),)]  # an angle of a slide, by the length of each tool
    return list(_FORMS.get(cause.key, ()))


def _split(errors: SurfaceErrors) -> list[tuple[str, ...]]:
    """Faces that a second tool may have cut where no tool is named: one, or all from one to the free end."""
    rows = errors.places
    z = {
        name: at
        for (name,), at, face in zip(
            rows.labels(_EACH), rows.number("z_mm").tolist(), rows.number("face").tolist(), strict=True
        )
        if face
    }
    faces = sorted(z, key=lambda name: z[name])
    if len(faces) < 2:
        return []
    ends = [tuple(faces[k:]) for k in range(1, len(faces) - 1)]
    return [*((name,) for name in faces), *(end for end in ends if len(end) > 1 and len(end) < len(faces) - 1)]


def _usual(basis: Basis) -> Basis:
    """Less what it is at the usual depth, for which offsets are set; times the depth, as `Over.DEPTH` multiplies."""

    def less(p: Places) -> Array:
        depth = p.number("depth_mm")
        return np.asarray(basis(p) * (1.0 - np.median(depth) / depth)[:, None])

    return less


def _on(names: tuple[str, ...], basis: Basis) -> Basis:
    def only(p: Places) -> Array:
        return np.asarray(basis(p) * _is(p, "feature", names))

    return only


def _is(p: Places, column: str, values: tuple[object, ...]) -> Array:
    return np.isin(p.columns[column], np.array(values, dtype=object)).astype(np.float64)[:, None]


def _over(way: Way, form: Form, errors: SurfaceErrors, series: SeenSeries) -> Iterator[Way]:
    """A form as it goes over the parts."""
    if way.over is Over.TEMPERATURE:
        for signal in errors.signals:
            yield _made(replace(way, signal=signal), form, (), _powers(signal, 1))
        if not errors.signals:
            yield _made(way, form, (), _powers("part", 2))
    elif way.over is Over.STEP:
        for step in range(LEAST_STEP, len(series.parts) - LEAST_STEP + 1):
            at = {part.setting.get(way.tool) for part in series.parts[step : step + 1]}
            since = [
                k for k, seen_part in enumerate(series.parts) if k >= step and seen_part.setting.get(way.tool) in at
            ]
            yield _made(replace(way, step=step), form, (), _among(since))
    elif way.over is Over.WEAR:
        yield _made(way, form, (), _worn)
    elif way.over is Over.DEPTH:
        yield _made(way, form, (), lambda p: p.number("depth_mm")[:, None])
    else:
        scope = {Over.SETTING: ("setting",), Over.SCATTER: ("part",)}.get(way.over, ())
        yield _made(way, form, scope, lambda p: np.ones((len(p), 1)))


def _powers(column: str, degree: int) -> Basis:
    """1, the column as a share of its largest, its square …"""

    def basis(p: Places) -> Array:
        value = p.number(column)
        return np.asarray(np.vander(value / (np.abs(value).max() or 1.0), degree + 1, increasing=True))

    return basis


def _among(parts: Sequence[int]) -> Basis:
    return lambda p: _is(p, "part", tuple(parts))


def _worn(p: Places) -> Array:
    """Evenly with the minutes in cut, and with their root while an edge breaks in; and what it wears along one pass.

    At the place where a share q of a pass is done the edge has cut m + q·Δm minutes: w(m) + q·Δm·w'(m).
    """
    minutes, along = p.number("minutes"), p.number("reach")
    root = np.sqrt(minutes)
    return np.column_stack([minutes, root, along, along / np.maximum(minutes, 1.0)])


def _made(way: Way, form: Form, scope: tuple[str, ...], course: Basis) -> Way:
    terms = tuple(
        Term(way.cause.key, (*of, *scope), _seen(way, basis, course), lambda s: np.zeros(0)) for of, basis in form
    )
    return replace(way, terms=terms)


def _seen(way: Way, basis: Basis, course: Basis) -> Basis:
    def seen(p: Places) -> Array:
        shape, over = basis(p), course(p)
        product = (shape[:, :, None] * over[:, None, :]).reshape(len(p), -1)
        of_tool = _is(p, "tool", (way.tool,)) if way.tool else 1.0
        return np.asarray(product * of_tool * _share(way, p))

    return seen


def _share(way: Way, p: Places) -> Array:
    """1 where the device sees it, −1 on a calibrated part that the machine reads with its own error."""
    cut = p.number("cut")[:, None]
    here = _is(p, "device", tuple(seen_by.value for seen_by in way.seen_by))
    by_probe = _is(p, "device", (SeenBy.MACHINE.value,))
    if way.cause.on_standard_part:
        return here
    standard = -by_probe if way.cause.key == "machine" else np.zeros_like(by_probe)
    return np.asarray(cut * here + (1.0 - cut) * standard)
