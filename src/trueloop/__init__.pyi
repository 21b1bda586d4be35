"""The stable names of trueloop, each beside the module that defines it. docs/python.md shows how they go together."""

# Files that come with trueloop, and what is raised for input that is refused.
# A turned part: profile, touches, correction.
from trueloop.domain.limits import Limits as Limits

# NC programs.
from trueloop.domain.map_options import MapOptions as MapOptions
from trueloop.errors import TrueloopError as TrueloopError
from trueloop.formats.cad.dxf import read_dxf as read_dxf
from trueloop.formats.cad.step_profile import read_step_profile as read_step_profile
from trueloop.formats.examples import example as example

# A machine's own errors.
from trueloop.formats.jobs.machine_toml import read_machine as read_machine
from trueloop.formats.measurements.field_csv import read_field as read_field
from trueloop.formats.measurements.history_csv import read_history as read_history
from trueloop.formats.measurements.readings_csv import read_readings as read_readings
from trueloop.formats.measurements.touches_csv import read_touches as read_touches
from trueloop.formats.program_file import read_program as read_program
from trueloop.formats.tables.model_file import model_to_json as model_to_json
from trueloop.formats.tables.model_file import read_model as read_model
from trueloop.formats.tables.table_csv import table_to_csv as table_to_csv
from trueloop.geometry.validate import checked_profile as checked_profile
from trueloop.jobs.compensate import compensate_job as compensate_job
from trueloop.jobs.compensate import write_correction as write_correction
from trueloop.jobs.turned import read_job as read_job
from trueloop.jobs.turned import read_part as read_part
from trueloop.loops.turned.process_intermittent import compensate as compensate
from trueloop.machine.identify.form import fit_form as fit_form
from trueloop.machine.identify.hold_out import compare as compare
from trueloop.machine.model.history import signals_at_end as signals_at_end
from trueloop.machine.model.overview import curves as curves
from trueloop.machine.model.overview import overview as overview
from trueloop.machine.model.validity import known_state as known_state
from trueloop.nc.check.check import check as check
from trueloop.nc.field.field import function_field as function_field
from trueloop.nc.field.field import similarity_field as similarity_field
from trueloop.nc.match.difference import path_difference as path_difference
from trueloop.nc.program.program_time import program_time as program_time
from trueloop.nc.translate.translate import translate as translate

# Figures of the reports, as specifications of Plotly.
from trueloop.report.machine.page import residual_figure as residual_figure
from trueloop.report.machine.page import term_figure as term_figure
from trueloop.report.notebook import shown as shown
from trueloop.report.turned.correction_json import correction_as_dict as correction_as_dict
from trueloop.report.turned.curves import error_curve as error_curve
from trueloop.report.turned.features import feature_summaries as feature_summaries
from trueloop.report.turned.whiskers import after_enlarged as after_enlarged
from trueloop.report.turned.whiskers import before_and_after as before_and_after
from trueloop.turned.options import Options as Options
from trueloop.turned.touches.touches import Gauging as Gauging
from trueloop.turned.touches.touches import error_vectors as error_vectors

__version__: str
