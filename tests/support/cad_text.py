"""B-spline surfaces read from the text of STEP and IGES files, evaluated by geomdl: no CAD kernel has a part in it."""

import re
from pathlib import Path
from typing import Any

import numpy as np
from geomdl import NURBS

from trueloop.arrays import Array

NUMBER = r"-?\d+\.?\d*(?:[ED][-+]?\d+)?"


def points_of_step(path: Path, u: Array, v: Array) -> Array:
    """Points (n, 3) of the one B-spline surface of a STEP file, at parameters on [0, 1]."""
    text = re.sub(r"\s+", "", path.read_text(encoding="ascii"))
    rows = re.search(r"B_SPLINE_SURFACE(?:_WITH_KNOTS)?\((?:'',)?(\d+),(\d+),\((\(#.*?\))\),", text)
    assert rows is not None
    names = [row.split(",") for row in re.findall(r"\(([^()]*)\)", rows[3])]
    at = dict(re.findall(r"(#\d+)=CARTESIAN_POINT\('',\(([^)]*)\)\)", text))
    control = np.array([[[float(x) for x in at[name].split(",")] for name in row] for row in names])
    lists = r"\(([\d,]+)\),\(([\d,]+)\),\(([^)]*)\),\(([^)]*)\)"
    knots = re.search(rf"B_SPLINE_SURFACE(?:_WITH_KNOTS)?\((?:''.*?\.[FTU]\.,\.[FTU]\.,\.[FTU]\.,)?{lists}", text)
    assert knots is not None
    counts = [[int(k) for k in knots[i].split(",")] for i in (1, 2)]
    values = [[float(k) for k in knots[i].split(",")] for i in (3, 4)]
    weights = np.ones(control.shape[:2])
    if (found := re.search(r"RATIONAL_B_SPLINE_SURFACE\(\((\(.*?\))\)\)", text)) is not None:
        weights = np.array([[float(w) for w in row.split(",")] for row in re.findall(r"\(([^()]*)\)", found[1])])
    repeated = [np.repeat(k, c).tolist() for k, c in zip(values, counts, strict=True)]
    return _evaluated((int(rows[1]), int(rows[2])), repeated, control, weights, u, v)


def points_of_iges(path: Path, u: Array, v: Array) -> Array:
    """Points (n, 3) of the one rational B-spline surface (entity 128) of an IGES file, at parameters on [0, 1]."""
    lines = path.read_text(encoding="ascii").splitlines()
    text = "".join(line[:64].strip() for line in lines if line[72:73] == "P")
    (record,) = re.findall(r"(?:^|;)128,([^;]*);", text)
    numbers = [float(x.replace("D", "E")) for x in re.findall(NUMBER, record)]
    k1, k2, m1, m2 = map(int, numbers[:4])
    rest = np.array(numbers[9:])
    counts = np.cumsum([k1 + m1 + 2, k2 + m2 + 2, (k1 + 1) * (k2 + 1), 3 * (k1 + 1) * (k2 + 1)])
    knots_u, knots_v, weights, control, _ = np.split(rest, counts)
    control = control.reshape(k2 + 1, k1 + 1, 3).transpose(1, 0, 2)
    weights = weights.reshape(k2 + 1, k1 + 1).T
    return _evaluated((m1, m2), [knots_u.tolist(), knots_v.tolist()], control, weights, u, v)


def _evaluated(degrees: tuple[int, int], knots: list[Any], control: Array, weights: Array, u: Array, v: Array) -> Array:
    surface = NURBS.Surface()
    surface.degree_u, surface.degree_v = degrees
    surface.ctrlpts_size_u, surface.ctrlpts_size_v = control.shape[:2]
    surface.ctrlptsw = (
        np.concatenate([control * weights[..., None], weights[..., None]], axis=2).reshape(-1, 4).tolist()
    )
    surface.knotvector_u, surface.knotvector_v = knots
    return np.array([surface.evaluate_single(pair) for pair in zip(u.tolist(), v.tolist(), strict=True)])
