"""From touches to a corrected program, a machine's errors and a surface's pattern: a notebook as a script.

Editors and Jupytext open it as cells; `python notebook.py` runs it.
"""

# %% [markdown]
# # A turned part
# A part that NIST measured in the 1990s: touches after the semi-finish cut, and the finish program to be corrected.

# %%
import numpy as np

import trueloop

job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
correction = trueloop.compensate(job.inputs)
for feature in trueloop.feature_summaries(correction):
    print(f"{feature.feature:16} {feature.correction:28} {feature.expected}")

# %%
trueloop.shown(trueloop.before_and_after(correction))

# %%
dome = job.inputs.profile.names.index("dome")
trueloop.shown(trueloop.error_curve(correction, dome))

# %%
files = trueloop.write_correction(correction, "out/notebook", job.files)
print(correction.name_to_run, "of", *files)

# %% [markdown]
# # The machine's own errors
# Readings of a laser interferometer at two temperatures, a model, and what it says of X = 300 mm at 25 °C.

# %%
fitted = trueloop.fit_machine(trueloop.example("machine/machine.toml"), [trueloop.example("machine/readings.csv")])
model = fitted.found.model
state = trueloop.known_state(model, {"X": 300.0, "Y": 100.0, "Z": -100.0}, {"T1": 25.0})
error_um, u_um = 1e3 * model.error_mm(state)[0], 1e3 * model.standard_u_mm(state)[0]
for axis, error, u in zip("XYZ", error_um, u_um, strict=True):
    print(f"E along {axis}: {error:+.1f} µm, u = {u:.1f} µm")

# %%
trueloop.shown(trueloop.term_figure(trueloop.curves(model, {"T1": 25.0})[0]))

# %% [markdown]
# # A free-form surface
# What three measured parts have in common.

# %%
surface = trueloop.read_surface(trueloop.example("surface/surface.toml"))
inputs = surface.inputs
parts = trueloop.model_of(inputs.surface, inputs.parts[:3], inputs.options)
pattern = trueloop.pattern_of_parts(surface, parts)
random_um = 1e3 * np.array([part.separation.sigma_mm for part in parts])
print(f"pattern up to {1e3 * pattern.figures.largest_mm:.1f} µm; random {random_um.mean():.1f} µm a part")

# %%
maps = trueloop.maps_picture(pattern)  # in a notebook: IPython.display.SVG(maps)

# %% [markdown]
# # A shop's data
# Three finished shafts in a store, their series as tables, and the likely causes.

# %%
store = trueloop.make_store("out/notebook/shop.db")
trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
series = trueloop.follow_series(store)
tables = {one.characteristic: trueloop.to_frame(one.parts) for one in series.characteristics}
print({name: round(float(table["after_um"].mean()), 1) for name, table in tables.items()})

# %%
(diagnosis,) = trueloop.series_causes(store)
assert diagnosis.causes is not None, diagnosis.findings  # too few parts lead to no conclusion
causes = trueloop.to_frame(diagnosis.causes.candidates)
print(causes[["name", "probability"]].round(2).to_string(index=False))
