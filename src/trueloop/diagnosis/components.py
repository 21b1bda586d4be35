"""The components of the error at gauging points [6876 §3], scalars along the nominal outward normal, in mm.

With E the machine's error at cutting (c) and probing (p) temperatures and a the COMP_MTG that was applied:

    detected surface    s = E_c + a + COMP_PROC + ERROR_PROC      (from the nominal surface; what a CMM finds)
    controller at touch r = s − E_p                               (the machine stands elsewhere than it says)

so that on-machine inspection gives ERROR_PROC,RESID = r − COMP_MTG(T_p) + (COMP_MTG(T_c) − a). With compensation in
force, a = COMP_MTG(T_c), that is COORDS_ACTUAL = COORDS_CONTROLLER − COMP_MTG(T_p) of [6876 §3.3]. Without it and at
equal temperatures the machine's error cancels, as [6876 §3.2] says. (The report's glossary adds COMP_MTG where its
equation subtracts; a simulated probing shows that the equation is right.)
"""

from dataclasses import dataclass, replace

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.machine.model.model import MachineModel, State
from trueloop.statistics import rms


@dataclass(frozen=True)
class Inspections:
    """One finished part, inspected on the machine and on a CMM, at n gauging points; all (n, 3) in part coordinates.

    `controller_mm` is what the control reported for the point of contact, before any adjustment. `normal` points out of
    the material. `touch_u_mm` and `cmm_u_mm` are standard uncertainties of one point. `comp_proc_mm` (n,) is the
    process correction that was applied, along the normal; 0 without. `tool_mm` and `probe_mm` (n, 3) are the cutting
    tool and the stylus of each point, where it was not one of each for all.
    """

    nominal_mm: Array
    normal: Array
    controller_mm: Array
    cmm_mm: Array
    touch_u_mm: float
    cmm_u_mm: float
    comp_proc_mm: Array | float = 0.0
    tool_mm: Array | None = None
    probe_mm: Array | None = None


@dataclass(frozen=True)
class Components:
    """Every quantity of the glossary of [6876] at n gauging points, (n,), mm along the normal.

    `u_*` are standard uncertainties. Surfaces are places along the normal, counted from NOMINALSURFACE_CMM.
    """

    comp_mtg_cutting: Array
    comp_mtg_probing: Array
    comp_mtg_applied: Array
    comp_proc: Array
    error_pp: Array
    error_proc: Array
    error_proc_resid: Array
    error_mtg: Array
    error_mtg_resid: Array
    u_error_pp: Array
    u_error_proc: Array
    u_error_mtg: Array

    @property
    def detected_surface(self) -> Array:
        """Returns COMPENSATEDSURFACE_DETECTED, or UNCOMPENSATEDSURFACE_DETECTED when nothing was compensated."""
        return self.error_pp

    @property
    def nominal_surface_mt(self) -> Array:
        """Returns NOMINALSURFACE_MT, inferred from on-machine inspection: off by what the machine model left."""
        return self.error_mtg_resid

    @property
    def uncompensated_nominal_surface_mt(self) -> Array:
        """Returns UNCOMPENSATEDNOMINALSURFACE_MT,HYPOTHETICAL: where it would lie without COMP_MTG."""
        return self.error_mtg

    @property
    def gt_compensated_surface(self) -> Array:
        """Returns GTCOMPENSATEDSURFACE: the part cut with the machine's errors compensated, the process' not."""
        return self.error_pp - self.comp_proc

    @property
    def uncompensated_surface(self) -> Array:
        """Returns UNCOMPENSATEDSURFACE_HYPOTHETICAL: the part cut without any compensation."""
        return self.error_pp - self.comp_proc - self.comp_mtg_applied

    @property
    def uncompensated_error(self) -> Array:
        """Returns UNCOMPENSATEDERROR_HYPOTHETICAL = ERROR_MTG + ERROR_PROC."""
        return self.error_mtg + self.error_proc


def error_components(
    model: MachineModel, inspections: Inspections, cutting: State, probing: State, *, compensated: bool
) -> Components:
    """Takes the error at each gauging point apart.

    `cutting` and `probing` hold axis positions, tool and probe lengths and temperatures (T_CUTTING, T_PROBING) at each
    point. `compensated` says whether COMP_MTG(T_CUTTING) of this model was in force during cutting. The uncertainty of
    the process error contains how differently the model may err at the two temperatures [6876 footnote 6]; the
    machine's contains that and the CMM's. A part coordinate system discrepancy must have been taken out of `cmm_mm`
    (`without_discrepancy`). Raises MCH-SHAPE when arrays do not belong together.
    """
    _check(inspections, cutting, probing)
    comp_cutting, comp_probing = (_along(inspections.normal, model.comp_mtg_mm(state)) for state in (cutting, probing))
    applied = comp_cutting if compensated else np.zeros_like(comp_cutting)
    comp_proc = np.broadcast_to(np.asarray(inspections.comp_proc_mm, dtype=np.float64), applied.shape)
    reported = _along(inspections.normal, inspections.controller_mm - inspections.nominal_mm)
    error_proc_resid = reported - comp_probing + (comp_cutting - applied)
    error_pp = _along(inspections.normal, inspections.cmm_mm - inspections.nominal_mm)
    error_mtg_resid = error_pp - error_proc_resid
    # The variance of the model's error at cutting minus that at probing: 0 where both are the same
    rows = model.sensitivities(cutting) - model.sensitivities(probing)
    along = np.einsum("ni,nij->nj", inspections.normal, rows)
    variance: Array = np.einsum("nj,jk,nk->n", along, model.covariance, along)
    u_proc = np.sqrt(inspections.touch_u_mm**2 + np.maximum(variance, 0.0))
    u_pp = np.full_like(u_proc, inspections.cmm_u_mm)
    return Components(
        comp_mtg_cutting=comp_cutting,
        comp_mtg_probing=comp_probing,
        comp_mtg_applied=applied,
        comp_proc=comp_proc,
        error_pp=error_pp,
        error_proc=error_proc_resid - comp_proc,
        error_proc_resid=error_proc_resid,
        error_mtg=error_mtg_resid - applied,
        error_mtg_resid=error_mtg_resid,
        u_error_pp=u_pp,
        u_error_proc=u_proc,
        u_error_mtg=np.hypot(u_proc, u_pp),
    )


def _along(normal: Array, vectors: Array) -> Array:
    along: Array = np.einsum("ni,ni->n", normal, vectors)
    return along


def _check(inspections: Inspections, cutting: State, probing: State) -> None:
    counts = [
        len(a) for a in (inspections.nominal_mm, inspections.normal, inspections.controller_mm, inspections.cmm_mm)
    ]
    counts += [len(cutting.positions), len(probing.positions)]
    if len(set(counts)) != 1 or not np.allclose(np.linalg.norm(inspections.normal, axis=1), 1.0, atol=1e-6):
        raise Code.MCH_SHAPE.refusal(
            f"gauging points, normals, touches, CMM points, cutting and probing positions number {counts}",
            hint="give each point once in each, in the same order, with normals of length 1",
            values={"counts": counts},
        )


FAINTEST = 1e-6
"""A motion that shifts the points by less than this share of the strongest is not seen by them."""


@dataclass(frozen=True)
class FrameDiscrepancy:
    """A small rigid motion from the machine's part frame to the CMM's: p → p + shift + turn × p.

    `standard_u` are of (shift, turn), NaN for motions that the points do not see (a shaft turned about its axis), which
    are left at 0. `rms_before_mm` and `rms_after_mm` are of the differences along the normals.
    """

    shift_mm: Array
    turn_rad: Array
    standard_u: Array
    rms_before_mm: float
    rms_after_mm: float

    def apply(self, points_mm: Array) -> Array:
        """Points of the machine's frame as the CMM sees them, (n, 3)."""
        moved: Array = points_mm + self.shift_mm + np.cross(self.turn_rad, points_mm)
        return moved

    def undo(self, points_mm: Array) -> Array:
        """Returns the CMM's points in the machine's frame, to first order, (n, 3)."""
        moved: Array = points_mm - self.shift_mm - np.cross(self.turn_rad, points_mm)
        return moved


def fit_frame_discrepancy(seen: Inspections, error_proc_resid_mm: Array) -> FrameDiscrepancy:
    """Returns the rigid motion that best explains, along the normals, CMM minus on-machine errors, by least squares.

    What the machine model left (ERROR_MTG,RESID) and looks like a rigid motion goes into it too: a constant offset of X
    looks like a part set up off centre. Take out the discrepancy only where the two frames were found anew.
    """
    difference = np.einsum("ni,ni->n", seen.normal, seen.cmm_mm - seen.nominal_mm) - error_proc_resid_mm
    size = max(float(np.abs(seen.nominal_mm).max()), 1e-9)
    rows = np.hstack([seen.normal, np.cross(seen.nominal_mm, seen.normal) / size])
    left, strength, right = np.linalg.svd(rows, full_matrices=False)
    seen_by = strength > FAINTEST * strength[0]
    inverse = np.where(seen_by, 1 / np.where(seen_by, strength, 1.0), 0.0)
    solution = right.T @ (inverse * (left.T @ difference))
    rest = difference - rows @ solution
    freedom = max(len(rows) - int(seen_by.sum()), 1)
    variance = float(rest @ rest) / freedom * np.einsum("kj,k->j", right**2, inverse**2)
    unseen = np.einsum("kj,k->j", right**2, ~seen_by) > FAINTEST
    scale = np.array([1.0] * 3 + [1 / size] * 3)
    u = np.where(unseen, np.nan, np.sqrt(variance) * scale)
    solution = solution * scale
    return FrameDiscrepancy(solution[:3], solution[3:], u, rms(difference), rms(rest))


def without_discrepancy(inspections: Inspections, discrepancy: FrameDiscrepancy) -> Inspections:
    """The inspections with the CMM's points brought into the machine's part frame."""
    return replace(inspections, cmm_mm=discrepancy.undo(inspections.cmm_mm))
