"""`finished`: a shaft on a Fanuc lathe, micrometer readings of FINISHED parts, one after another; three ways to carry the correction."""
import math
import re
from pathlib import Path

import numpy as np

import gauges
from lathe import Cut, Edge, Profile, best_offset, rms
from product import Broken
from reader import read

PROGRAM = """O1200
G21 G40 G99
T0303
G97 S1500 M3
G0 X50. Z5.
G0 X0. Z2.
G42 G1 Z0. F0.1
X28.
X30. Z-1.
Z-30.
X36.
Z-52.
X44.
Z-75.
X46.
G40 X52. Z-73.
G0 X100. Z100.
M30
"""
SHAFT = Profile((22, -75), [("seat 44", (22, -52)), ("shoulder 2", (18, -52)), ("seat 36", (18, -30)), ("shoulder 1", (15, -30)),
                            ("seat 30", (15, -1)), ("chamfer", (14, 0)), ("front", (0, 0))])
CYLINDERS = ("seat 44", "seat 36", "seat 30")
CLAMP, SCATTER, GAUGE, WEAR = 0.6, 0.5, 0.6, 0.5        # µm


def job(k, way, last, extra=""):
    after = f'after_record = "{last}/record.json"\n' if last else ""
    by = "contour" if way == "corrected" else "offset"
    cut = f'cut_with = "{last}/record.json"\ncut_by = "{way}"\n' if last else 'cut_with = "given"\n'
    return (f'[part]\nname = "shaft"\nserial = "{k:03d}"\n{SHAFT.toml()}{extra}'
            f'[tool]\nnose_radius_mm = 0.8\nnumber = 3\nname = "T3"\ninsert = "DNMG 15"\ncorner = "1"\n'
            f'[programs]\ndialect = "fanuc-lathe"\nfinish = "finish.nc"\n{cut}'
            f'[gauging]\nreadings = "part{k}.csv"\n{after}[compensation]\nby = "{by}"\n[output]\nfolder = "out{k}"\n')


def entered(words, tool="T3"):
    """(dX radius, dZ) µm of the line that tells the operator what to enter."""
    m = re.search(tool + r" wear X ([−+-]?[\d.]+) mm \(diameter\), Z ([−+-]?[\d.]+)", words)
    if not m:
        raise Broken(f"no wear to enter in {words!r}")
    x, z = (float(v.replace("−", "-")) for v in m.groups())
    return x / 2 * 1e3, z * 1e3


def series(way, trueloop, folder, seed, parts, say, extra="", store=False):
    """Runs one series; returns the shop's own log of it, a dict a part."""
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "finish.nc").write_text(PROGRAM)
    if store:
        trueloop("db", "init", cwd=folder)
    edge = Edge(0.8, (), 0.0, WEAR)
    setting = (rng.uniform(15, 28), rng.uniform(-9, 9))
    taper = 0.04
    run, wear, log, program_of, last = "finish.nc", np.zeros(2), [], "as given", None
    places = SHAFT.places(2, 3.0, CYLINDERS)
    faces = SHAFT.places(3, 0.5, ("shoulder 1", "shoulder 2", "front"))
    limit = 2 * math.sqrt(2) * math.sqrt(CLAMP**2 + SCATTER**2 + GAUGE**2 / 4 + WEAR**2 + 0.3**2)
    for k in range(1, parts + 1):
        edge.age = k - 1
        clamping = rng.normal(0, CLAMP, 2)
        cut = Cut(edge, setting=setting, wear_table=tuple(wear), clamping=tuple(clamping), taper=taper, chuck_z=-75, scatter=SCATTER)
        control = read(folder / run, "fanuc-lathe")
        truth, again = cut.surface(control.moves, places + faces, rng)
        e = truth[:len(places)]
        ideal = np.array([cut.repeating(*p[1:]) for p in places])       # what an uncorrected program would leave, part after part
        left = 0 * ideal if way == "corrected" else best_offset(ideal, places)[1]
        floor = rms(left + (truth - again)[:len(places)])               # left by whoever knows all that repeats
        length = gauges.true_length(faces, truth[len(places):], "front", "shoulder 1")
        gauges.micrometer(folder / f"part{k}.csv", places, e, rng, f"{k:03d}", u=GAUGE,
                          lengths=[("shoulder 1", "front", 30.0, length)])
        row = dict(part=k, ran=run, program=program_of, wear=tuple(wear), error=e, rms=rms(e), floor=floor, code="", limit=limit)
        (folder / f"job{k}.toml").write_text(job(k, way, last, extra))
        answer, code, message = trueloop.json("compensate", f"job{k}.toml", cwd=folder)
        if code:
            row["code"], row["message"] = code, message
        else:
            row["record"], last = answer["record_id"], f"out{k}"
            row["u"] = {f["feature"]: f["predicted_expanded_u_um"] for f in answer["features"]}
            if way == "wear":
                wear = wear + entered((answer.get("by_tool") or {}).get("words", ""))
            else:
                run = f"out{k}/{way}.nc"
                program_of = answer["record_id"]
        log.append(row)
        say(f"{way:9s} part {k:2d}  ran {row['ran']:20s} wear X {row['wear'][0]:+7.1f} µm (radius)   sizes: rms {row['rms']:6.2f}  worst "
            f"{e[np.argmax(abs(e))]:+7.2f}  floor {floor:5.2f}   {code}")
    return log


def verdict(way, log):
    later = [r for r in log if r["part"] > 1]
    up = [r["part"] for r in later if r["rms"] > r["limit"]]
    refused = [(r["part"], r["code"]) for r in log if r["code"]]
    inside = []
    for a, b in zip(log, log[1:]):
        if a.get("u"):
            inside += [abs(v) <= a["u"][p[0]] for v, p in zip(b["error"], SHAFT.places(2, 3.0, CYLINDERS))]
    figures = f"{way}: first {log[0]['rms']:.1f}, later rms {rms([r['rms'] for r in later]):.2f} µm, limit {log[0]['limit']:.2f}, inside ±U " \
              f"{100 * np.mean(inside) if inside else float('nan'):.0f} %"
    reasons = []
    if up:
        reasons.append(f"{way}: parts {up} are back above {log[0]['limit']:.1f} µm")
    if refused:
        reasons.append(f"{way}: refused {refused}")
    return figures, reasons


def run(trueloop, folder, seed, parts, say):
    figures, reasons = [], []
    for way in ("wear", "offsets", "corrected"):
        try:
            f, r = verdict(way, series(way, trueloop, Path(folder) / way, seed, parts or 10, say))
        except Broken as b:
            f, r = f"{way}: stopped", [f"{way}: {b}"]
        figures.append(f)
        reasons += r
    return "; ".join(figures), reasons
