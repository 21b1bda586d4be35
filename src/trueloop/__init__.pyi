"""The stable names of trueloop, each from the module that defines it. docs/python.md shows how they go together."""

# In the order of use.
# isort: off

# Files that come with trueloop, files written whole or not at all, and what is raised for what is refused.
from trueloop.formats.examples import example as example
from trueloop.formats.outputs import write_all as write_all
from trueloop.errors import TrueloopError as TrueloopError

# A turned part: profile, touches, correction.
from trueloop.jobs.turned.job import read_part as read_part
from trueloop.jobs.turned.job import read_job as read_job
from trueloop.formats.cad.dxf import read_dxf as read_dxf
from trueloop.formats.cad.step_profile import read_step_profile as read_step_profile
from trueloop.geometry.validate import checked_profile as checked_profile
from trueloop.formats.measurements.touches_csv import read_touches as read_touches
from trueloop.turned.touches.touches import Gauging as Gauging
from trueloop.turned.touches.touches import error_vectors as error_vectors
from trueloop.turned.options import Options as Options
from trueloop.domain.option import Limits as Limits
from trueloop.loops.turned.process_intermittent import compensate as compensate
from trueloop.report.turned.summary import feature_summaries as feature_summaries
from trueloop.report.turned.correction_json import correction_as_dict as correction_as_dict
from trueloop.formats.tables.control_tables import table_to_csv as table_to_csv
from trueloop.jobs.turned.compensate import write_correction as write_correction
from trueloop.jobs.turned.compensate import compensate_job as compensate_job
from trueloop.jobs.turned.compensate import CorrectedEdge as CorrectedEdge
from trueloop.jobs.turned.compensate import CorrectedPart as CorrectedPart
from trueloop.jobs.turned.compensate import compensate_part as compensate_part

# NC programs.
from trueloop.formats.input_file import read_program as read_program
from trueloop.nc.check.check import check as check
from trueloop.nc.match.difference import path_difference as path_difference
from trueloop.nc.field import similarity_field as similarity_field
from trueloop.nc.field import function_field as function_field
from trueloop.formats.measurements.field_csv import read_field as read_field
from trueloop.domain.option import MapOptions as MapOptions
from trueloop.jobs.machine.mapped_program import displace_program as displace_program

# A machine's own errors.
from trueloop.jobs.machine.machine_model import fit_machine as fit_machine
from trueloop.jobs.machine.machine_model import FittedMachine as FittedMachine
from trueloop.formats.jobs.machine_toml import read_machine as read_machine
from trueloop.formats.measurements.readings_csv import read_readings as read_readings
from trueloop.formats.measurements.history_csv import read_history as read_history
from trueloop.machine.identify.form import fit_form as fit_form
from trueloop.machine.identify.judge_fit import compare as compare
from trueloop.formats.tables.model_file import read_model as read_model
from trueloop.formats.tables.model_file import model_to_json as model_to_json
from trueloop.jobs.machine.machine_model import signals_of as signals_of
from trueloop.machine.model.validity import known_state as known_state
from trueloop.machine.model.model import overview as overview
from trueloop.machine.model.model import curves as curves
from trueloop.machine.correct import Setup as Setup
from trueloop.jobs.machine.mapped_program import ModelFile as ModelFile
from trueloop.jobs.machine.mapped_program import compensate_program as compensate_program

# A free-form surface: measured parts, their pattern, the corrected surface and program.
from trueloop.jobs.surface.job import read_surface as read_surface
from trueloop.loops.surface.surface import deviations_of as deviations_of
from trueloop.loops.surface.surface import model_of as model_of
from trueloop.jobs.surface.job import pattern_of_parts as pattern_of_parts
from trueloop.jobs.surface.job import correct_surface as correct_surface
from trueloop.jobs.surface.job import corrected_files as corrected_files

# A shop's records: inspections and a store; series, charts, certificates and causes from it; tables for a notebook.
from trueloop.formats.inspections.known import read_measured_file as read_measured_file
from trueloop.jobs.store.opened import make_store as make_store
from trueloop.jobs.store.opened import open_store as open_store
from trueloop.jobs.series import add_inspections as add_inspections
from trueloop.jobs.series import stored_inspections as stored_inspections
from trueloop.jobs.series import follow_series as follow_series
from trueloop.jobs.monitor.charts import control_charts as control_charts
from trueloop.jobs.monitor.certificate import certify_part as certify_part
from trueloop.jobs.diagnose.seen_series import series_causes as series_causes
from trueloop.jobs.diagnose.seen_series import part_causes as part_causes
from trueloop.jobs.measure.next_measurement import plan_measurements as plan_measurements
from trueloop.report.shape import to_frame as to_frame

# A milled part: numbers to enter at the control.
from trueloop.jobs.milled import read_milled as read_milled
from trueloop.jobs.milled import entries_for_next_part as entries_for_next_part

# Figures of the reports: specifications of Plotly, but for maps_picture, which is SVG.
from trueloop.report.turned.figures.whiskers import before_and_after as before_and_after
from trueloop.report.turned.figures.whiskers import after_enlarged as after_enlarged
from trueloop.report.turned.figures.curves import error_curve as error_curve
from trueloop.report.machine.page import term_figure as term_figure
from trueloop.report.machine.page import residual_figure as residual_figure
from trueloop.report.surface.page import maps_picture as maps_picture
from trueloop.report.style import shown as shown

__version__: str
