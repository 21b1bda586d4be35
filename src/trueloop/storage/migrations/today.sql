CREATE TABLE trueloop_schema ( version_num VARCHAR(32) NOT NULL, CONSTRAINT trueloop_schema_pkc PRIMARY KEY (version_num) )
CREATE TABLE part_type ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, part_type TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT part_type_once UNIQUE (identity, version), CONSTRAINT part_type_superseded_once UNIQUE (supersedes), CONSTRAINT part_type_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES part_type (id) )
CREATE INDEX part_type_by_part_type ON part_type (part_type)
CREATE TABLE part ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, part_type TEXT, serial TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT part_once UNIQUE (identity, version), CONSTRAINT part_superseded_once UNIQUE (supersedes), CONSTRAINT part_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES part (id) )
CREATE INDEX part_by_part_type ON part (part_type)
CREATE INDEX part_by_serial ON part (serial, part_type)
CREATE TABLE machine ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, machine TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT machine_once UNIQUE (identity, version), CONSTRAINT machine_superseded_once UNIQUE (supersedes), CONSTRAINT machine_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES machine (id) )
CREATE INDEX machine_by_machine ON machine (machine)
CREATE TABLE tool ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, tool TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT tool_once UNIQUE (identity, version), CONSTRAINT tool_superseded_once UNIQUE (supersedes), CONSTRAINT tool_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES tool (id) )
CREATE INDEX tool_by_tool ON tool (tool)
CREATE TABLE edge ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, tool TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT edge_once UNIQUE (identity, version), CONSTRAINT edge_superseded_once UNIQUE (supersedes), CONSTRAINT edge_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES edge (id) )
CREATE INDEX edge_by_tool ON edge (tool)
CREATE TABLE setting ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, edge TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT setting_once UNIQUE (identity, version), CONSTRAINT setting_superseded_once UNIQUE (supersedes), CONSTRAINT setting_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES setting (id) )
CREATE INDEX setting_by_edge ON setting (edge)
CREATE TABLE program ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, program_sha256 TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT program_once UNIQUE (identity, version), CONSTRAINT program_superseded_once UNIQUE (supersedes), CONSTRAINT program_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES program (id) )
CREATE INDEX program_by_program_sha256 ON program (program_sha256)
CREATE TABLE program_text ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, program_sha256 TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT program_text_once UNIQUE (identity, version), CONSTRAINT program_text_superseded_once UNIQUE (supersedes), CONSTRAINT program_text_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES program_text (id) )
CREATE INDEX program_text_by_program_sha256 ON program_text (program_sha256)
CREATE TABLE cut ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, part_type TEXT, serial TEXT, stage TEXT, edge TEXT, correction TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT cut_once UNIQUE (identity, version), CONSTRAINT cut_superseded_once UNIQUE (supersedes), CONSTRAINT cut_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES cut (id) )
CREATE INDEX cut_by_part_type ON cut (part_type)
CREATE INDEX cut_by_serial ON cut (serial, part_type)
CREATE INDEX cut_by_stage ON cut (stage)
CREATE INDEX cut_by_edge ON cut (edge)
CREATE INDEX cut_by_correction ON cut (correction)
CREATE TABLE inspection ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, part_type TEXT, serial TEXT, file_sha256 TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT inspection_once UNIQUE (identity, version), CONSTRAINT inspection_superseded_once UNIQUE (supersedes), CONSTRAINT inspection_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES inspection (id) )
CREATE INDEX inspection_by_part_type ON inspection (part_type)
CREATE INDEX inspection_by_serial ON inspection (serial, part_type)
CREATE INDEX inspection_by_file_sha256 ON inspection (file_sha256)
CREATE TABLE inspection_link ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, cut TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT inspection_link_once UNIQUE (identity, version), CONSTRAINT inspection_link_superseded_once UNIQUE (supersedes), CONSTRAINT inspection_link_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES inspection_link (id) )
CREATE INDEX inspection_link_by_cut ON inspection_link (cut)
CREATE TABLE quarantine ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, cut TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT quarantine_once UNIQUE (identity, version), CONSTRAINT quarantine_superseded_once UNIQUE (supersedes), CONSTRAINT quarantine_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES quarantine (id) )
CREATE INDEX quarantine_by_cut ON quarantine (cut)
CREATE TABLE edge_event ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, edge TEXT, event TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT edge_event_once UNIQUE (identity, version), CONSTRAINT edge_event_superseded_once UNIQUE (supersedes), CONSTRAINT edge_event_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES edge_event (id) )
CREATE INDEX edge_event_by_edge ON edge_event (edge)
CREATE INDEX edge_event_by_event ON edge_event (event)
CREATE TABLE correction ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, part_type TEXT, serial TEXT, edge TEXT, program_sha256 TEXT, product TEXT, document TEXT NOT NULL, payload TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT correction_once UNIQUE (identity, version), CONSTRAINT correction_superseded_once UNIQUE (supersedes), CONSTRAINT correction_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES correction (id) )
CREATE INDEX correction_by_part_type ON correction (part_type)
CREATE INDEX correction_by_serial ON correction (serial, part_type)
CREATE INDEX correction_by_edge ON correction (edge)
CREATE INDEX correction_by_program_sha256 ON correction (program_sha256)
CREATE INDEX correction_by_product ON correction (product)
CREATE TABLE proposal ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, part_type TEXT, changes TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT proposal_once UNIQUE (identity, version), CONSTRAINT proposal_superseded_once UNIQUE (supersedes), CONSTRAINT proposal_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES proposal (id) )
CREATE INDEX proposal_by_part_type ON proposal (part_type)
CREATE INDEX proposal_by_changes ON proposal (changes)
CREATE TABLE proposal_decision ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, verdict TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT proposal_decision_once UNIQUE (identity, version), CONSTRAINT proposal_decision_superseded_once UNIQUE (supersedes), CONSTRAINT proposal_decision_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES proposal_decision (id) )
CREATE INDEX proposal_decision_by_verdict ON proposal_decision (verdict)
CREATE TABLE part_cut_with ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT part_cut_with_once UNIQUE (identity, version), CONSTRAINT part_cut_with_superseded_once UNIQUE (supersedes), CONSTRAINT part_cut_with_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES part_cut_with (id) )
CREATE TABLE touch ( inspection INTEGER NOT NULL, position INTEGER NOT NULL, point TEXT, feature TEXT, nominal_x_mm DOUBLE, nominal_z_mm DOUBLE, measured_x_mm DOUBLE, measured_z_mm DOUBLE, error_mm DOUBLE, line BIGINT, exact TEXT, PRIMARY KEY (inspection, position), FOREIGN KEY(inspection) REFERENCES inspection (id) ) WITHOUT ROWID
CREATE TABLE reading ( inspection INTEGER NOT NULL, position INTEGER NOT NULL, characteristic TEXT, quantity TEXT, actual DOUBLE, nominal DOUBLE, lower_limit DOUBLE, upper_limit DOUBLE, feature TEXT, other TEXT, axis TEXT, place_count BIGINT, place_1_mm DOUBLE, place_2_mm DOUBLE, place_3_mm DOUBLE, repeat BIGINT, standard_u DOUBLE, measured_at TEXT, temperature_c DOUBLE, line BIGINT, side TEXT, exact TEXT, PRIMARY KEY (inspection, position), FOREIGN KEY(inspection) REFERENCES inspection (id) ) WITHOUT ROWID
CREATE TABLE cmm_point ( inspection INTEGER NOT NULL, position INTEGER NOT NULL, name TEXT, measured_x_mm DOUBLE, measured_y_mm DOUBLE, measured_z_mm DOUBLE, nominal_x_mm DOUBLE, nominal_y_mm DOUBLE, nominal_z_mm DOUBLE, normal_x DOUBLE, normal_y DOUBLE, normal_z DOUBLE, exact TEXT, PRIMARY KEY (inspection, position), FOREIGN KEY(inspection) REFERENCES inspection (id) ) WITHOUT ROWID
CREATE TRIGGER part_type_no_update BEFORE UPDATE ON part_type BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER part_type_no_delete BEFORE DELETE ON part_type BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER part_no_update BEFORE UPDATE ON part BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER part_no_delete BEFORE DELETE ON part BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER machine_no_update BEFORE UPDATE ON machine BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER machine_no_delete BEFORE DELETE ON machine BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER tool_no_update BEFORE UPDATE ON tool BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER tool_no_delete BEFORE DELETE ON tool BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER edge_no_update BEFORE UPDATE ON edge BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER edge_no_delete BEFORE DELETE ON edge BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER setting_no_update BEFORE UPDATE ON setting BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER setting_no_delete BEFORE DELETE ON setting BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER program_no_update BEFORE UPDATE ON program BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER program_no_delete BEFORE DELETE ON program BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER program_text_no_update BEFORE UPDATE ON program_text BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER program_text_no_delete BEFORE DELETE ON program_text BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER cut_no_update BEFORE UPDATE ON cut BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER cut_no_delete BEFORE DELETE ON cut BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER inspection_no_update BEFORE UPDATE ON inspection BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER inspection_no_delete BEFORE DELETE ON inspection BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER inspection_link_no_update BEFORE UPDATE ON inspection_link BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER inspection_link_no_delete BEFORE DELETE ON inspection_link BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER quarantine_no_update BEFORE UPDATE ON quarantine BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER quarantine_no_delete BEFORE DELETE ON quarantine BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER edge_event_no_update BEFORE UPDATE ON edge_event BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER edge_event_no_delete BEFORE DELETE ON edge_event BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER correction_no_update BEFORE UPDATE ON correction BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER correction_no_delete BEFORE DELETE ON correction BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER proposal_no_update BEFORE UPDATE ON proposal BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER proposal_no_delete BEFORE DELETE ON proposal BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER proposal_decision_no_update BEFORE UPDATE ON proposal_decision BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER proposal_decision_no_delete BEFORE DELETE ON proposal_decision BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER part_cut_with_no_update BEFORE UPDATE ON part_cut_with BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER part_cut_with_no_delete BEFORE DELETE ON part_cut_with BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER touch_no_update BEFORE UPDATE ON touch BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER touch_no_delete BEFORE DELETE ON touch BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER reading_no_update BEFORE UPDATE ON reading BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER reading_no_delete BEFORE DELETE ON reading BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER cmm_point_no_update BEFORE UPDATE ON cmm_point BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER cmm_point_no_delete BEFORE DELETE ON cmm_point BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TABLE both_inspections ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, part_type TEXT, serial TEXT, machine TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT both_inspections_once UNIQUE (identity, version), CONSTRAINT both_inspections_superseded_once UNIQUE (supersedes), CONSTRAINT both_inspections_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES both_inspections (id) )
CREATE INDEX both_inspections_by_part_type ON both_inspections (part_type)
CREATE INDEX both_inspections_by_serial ON both_inspections (serial, part_type)
CREATE INDEX both_inspections_by_machine ON both_inspections (machine)
CREATE TABLE model_version ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, machine TEXT, parent_sha256 TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT model_version_once UNIQUE (identity, version), CONSTRAINT model_version_superseded_once UNIQUE (supersedes), CONSTRAINT model_version_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES model_version (id) )
CREATE INDEX model_version_by_machine ON model_version (machine)
CREATE INDEX model_version_by_parent_sha256 ON model_version (parent_sha256)
CREATE TABLE model_decision ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, verdict TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT model_decision_once UNIQUE (identity, version), CONSTRAINT model_decision_superseded_once UNIQUE (supersedes), CONSTRAINT model_decision_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES model_decision (id) )
CREATE INDEX model_decision_by_verdict ON model_decision (verdict)
CREATE TABLE standard_part ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, part_type TEXT, serial TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT standard_part_once UNIQUE (identity, version), CONSTRAINT standard_part_superseded_once UNIQUE (supersedes), CONSTRAINT standard_part_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES standard_part (id) )
CREATE INDEX standard_part_by_part_type ON standard_part (part_type)
CREATE INDEX standard_part_by_serial ON standard_part (serial, part_type)
CREATE TRIGGER both_inspections_no_update BEFORE UPDATE ON both_inspections BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER both_inspections_no_delete BEFORE DELETE ON both_inspections BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER model_version_no_update BEFORE UPDATE ON model_version BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER model_version_no_delete BEFORE DELETE ON model_version BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER model_decision_no_update BEFORE UPDATE ON model_decision BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER model_decision_no_delete BEFORE DELETE ON model_decision BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER standard_part_no_update BEFORE UPDATE ON standard_part BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER standard_part_no_delete BEFORE DELETE ON standard_part BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TABLE work_order ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, part_type TEXT, machine TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT work_order_once UNIQUE (identity, version), CONSTRAINT work_order_superseded_once UNIQUE (supersedes), CONSTRAINT work_order_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES work_order (id) )
CREATE INDEX work_order_by_part_type ON work_order (part_type)
CREATE INDEX work_order_by_machine ON work_order (machine)
CREATE TABLE run ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, work_order TEXT, machine TEXT, part_type TEXT, serial TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT run_once UNIQUE (identity, version), CONSTRAINT run_superseded_once UNIQUE (supersedes), CONSTRAINT run_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES run (id) )
CREATE INDEX run_by_work_order ON run (work_order)
CREATE INDEX run_by_machine ON run (machine)
CREATE INDEX run_by_part_type ON run (part_type)
CREATE INDEX run_by_serial ON run (serial, part_type)
CREATE TABLE run_fact ( id INTEGER NOT NULL, identity TEXT NOT NULL, version INTEGER NOT NULL, kept_at TEXT NOT NULL, kept_by TEXT NOT NULL, supersedes INTEGER, reason TEXT NOT NULL, sha256 TEXT NOT NULL, run TEXT, document TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT run_fact_once UNIQUE (identity, version), CONSTRAINT run_fact_superseded_once UNIQUE (supersedes), CONSTRAINT run_fact_supersedes_earlier CHECK (supersedes < id), FOREIGN KEY(supersedes) REFERENCES run_fact (id) )
CREATE INDEX run_fact_by_run ON run_fact (run)
CREATE TABLE event ( id INTEGER NOT NULL, at TEXT NOT NULL, who TEXT NOT NULL, what TEXT NOT NULL, subject TEXT NOT NULL, document TEXT NOT NULL, PRIMARY KEY (id) )
CREATE TABLE transfer ( id INTEGER NOT NULL, at TEXT NOT NULL, who TEXT NOT NULL, control TEXT NOT NULL, program_sha256 TEXT NOT NULL, name TEXT NOT NULL, direction TEXT NOT NULL, sent_sha256 TEXT NOT NULL, read_back_sha256 TEXT NOT NULL, outcome TEXT NOT NULL, document TEXT NOT NULL, PRIMARY KEY (id) )
CREATE TABLE alarm ( id INTEGER NOT NULL, at TEXT NOT NULL, source TEXT NOT NULL, code TEXT NOT NULL, said TEXT NOT NULL, document TEXT NOT NULL, machine TEXT NOT NULL, part_type TEXT NOT NULL, blocks INTEGER NOT NULL, PRIMARY KEY (id) )
CREATE TABLE alarm_acknowledged ( alarm INTEGER NOT NULL, at TEXT NOT NULL, who TEXT NOT NULL, why TEXT NOT NULL, PRIMARY KEY (alarm), FOREIGN KEY(alarm) REFERENCES alarm (id) )
CREATE TABLE certificate ( id INTEGER NOT NULL, part INTEGER NOT NULL, at TEXT NOT NULL, who TEXT NOT NULL, sha256 TEXT NOT NULL, verdict TEXT NOT NULL, content BLOB NOT NULL, PRIMARY KEY (id), FOREIGN KEY(part) REFERENCES part (id) )
CREATE TABLE program_release ( program_sha256 TEXT NOT NULL, at TEXT NOT NULL, who TEXT NOT NULL, why TEXT NOT NULL, PRIMARY KEY (program_sha256) )
CREATE TABLE temperature ( id INTEGER NOT NULL, machine TEXT NOT NULL, run TEXT NOT NULL, signal TEXT NOT NULL, at TEXT NOT NULL, celsius DOUBLE NOT NULL, PRIMARY KEY (id) )
CREATE TABLE run_touches ( id INTEGER NOT NULL, run TEXT NOT NULL, at TEXT NOT NULL, name TEXT NOT NULL, sha256 TEXT NOT NULL, content BLOB NOT NULL, PRIMARY KEY (id), CONSTRAINT run_touches_once UNIQUE (run, sha256) )
CREATE TABLE calibration ( id INTEGER NOT NULL, machine TEXT NOT NULL, at TEXT NOT NULL, who TEXT NOT NULL, document TEXT NOT NULL, PRIMARY KEY (id) )
CREATE TABLE order_state ( "order" TEXT NOT NULL, state TEXT NOT NULL, machine TEXT NOT NULL, changed_at TEXT NOT NULL, number INTEGER NOT NULL, version INTEGER NOT NULL, armed_parts INTEGER NOT NULL, PRIMARY KEY ("order") )
CREATE TABLE part_state ( part INTEGER NOT NULL, state TEXT NOT NULL, "order" TEXT NOT NULL, machine TEXT NOT NULL, changed_at TEXT NOT NULL, held_why TEXT NOT NULL, version INTEGER NOT NULL, PRIMARY KEY (part), FOREIGN KEY(part) REFERENCES part (id) )
CREATE TABLE step ( "order" TEXT NOT NULL, part INTEGER NOT NULL, no INTEGER NOT NULL, kind TEXT NOT NULL, state TEXT NOT NULL, run TEXT NOT NULL, program_sha256 TEXT NOT NULL, changed_at TEXT NOT NULL, attempts INTEGER NOT NULL, version INTEGER NOT NULL, PRIMARY KEY ("order", part, no), FOREIGN KEY(part) REFERENCES part (id) )
CREATE TABLE task ( id INTEGER NOT NULL, kind TEXT NOT NULL, subject TEXT NOT NULL, state TEXT NOT NULL, document TEXT NOT NULL, said TEXT NOT NULL, lease_until TEXT, problem TEXT, result TEXT, worker TEXT NOT NULL, made_by TEXT NOT NULL, made_at TEXT NOT NULL, changed_at TEXT NOT NULL, tries INTEGER NOT NULL, progress DOUBLE NOT NULL, PRIMARY KEY (id) )
CREATE TABLE account ( id INTEGER NOT NULL, name TEXT NOT NULL, display TEXT NOT NULL, argon2id TEXT NOT NULL, oidc_subject TEXT, role TEXT NOT NULL, language TEXT NOT NULL, created_at TEXT NOT NULL, disabled INTEGER NOT NULL, version INTEGER NOT NULL, unit TEXT DEFAULT 'mm' NOT NULL, PRIMARY KEY (id), CONSTRAINT account_once UNIQUE (name), CONSTRAINT account_once_of_subject UNIQUE (oidc_subject) )
CREATE TABLE session ( id_sha256 TEXT NOT NULL, account INTEGER NOT NULL, created_at TEXT NOT NULL, seen_at TEXT NOT NULL, expires_at TEXT NOT NULL, ended_at TEXT, address TEXT NOT NULL, PRIMARY KEY (id_sha256), FOREIGN KEY(account) REFERENCES account (id) )
CREATE TABLE api_key ( id INTEGER NOT NULL, machine TEXT NOT NULL, name TEXT NOT NULL, key_sha256 TEXT NOT NULL, scope TEXT NOT NULL, expires_at TEXT NOT NULL, ended_at TEXT, made_by TEXT NOT NULL, created_at TEXT NOT NULL, PRIMARY KEY (id), CONSTRAINT api_key_once UNIQUE (key_sha256) )
CREATE TABLE idempotency ( account TEXT NOT NULL, "key" TEXT NOT NULL, request_sha256 TEXT NOT NULL, status INTEGER NOT NULL, body BLOB NOT NULL, created_at TEXT NOT NULL, PRIMARY KEY (account, "key") )
CREATE TABLE upload ( id INTEGER NOT NULL, "by" TEXT NOT NULL, name TEXT NOT NULL, sha256 TEXT NOT NULL, created_at TEXT NOT NULL, content BLOB NOT NULL, PRIMARY KEY (id) )
CREATE TABLE machine_heard ( machine TEXT NOT NULL, at TEXT NOT NULL, document TEXT NOT NULL, PRIMARY KEY (machine) )
CREATE INDEX event_by_subject ON event (subject)
CREATE INDEX transfer_by_control ON transfer (control)
CREATE INDEX transfer_by_program_sha256 ON transfer (program_sha256)
CREATE INDEX alarm_by_machine ON alarm (machine)
CREATE INDEX alarm_by_part_type ON alarm (part_type)
CREATE INDEX certificate_by_part ON certificate (part)
CREATE INDEX temperature_by_run ON temperature (run)
CREATE INDEX calibration_by_machine_at ON calibration (machine, at)
CREATE INDEX order_state_by_machine_state ON order_state (machine, state)
CREATE INDEX order_state_by_number ON order_state (number)
CREATE INDEX part_state_by_order ON part_state ("order")
CREATE INDEX part_state_by_state_part ON part_state (state, part)
CREATE INDEX part_state_by_changed_at ON part_state (changed_at)
CREATE INDEX step_by_part ON step (part)
CREATE INDEX step_by_run ON step (run)
CREATE INDEX step_by_state_kind ON step (state, kind)
CREATE INDEX step_by_program_sha256 ON step (program_sha256)
CREATE INDEX task_by_state_id ON task (state, id)
CREATE INDEX task_by_subject ON task (subject)
CREATE INDEX session_by_account ON session (account)
CREATE INDEX idempotency_by_created_at ON idempotency (created_at)
CREATE TRIGGER work_order_no_update BEFORE UPDATE ON work_order BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER work_order_no_delete BEFORE DELETE ON work_order BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER run_no_update BEFORE UPDATE ON run BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER run_no_delete BEFORE DELETE ON run BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER run_fact_no_update BEFORE UPDATE ON run_fact BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER run_fact_no_delete BEFORE DELETE ON run_fact BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER event_no_update BEFORE UPDATE ON event BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER event_no_delete BEFORE DELETE ON event BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER transfer_no_update BEFORE UPDATE ON transfer BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER transfer_no_delete BEFORE DELETE ON transfer BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER alarm_no_update BEFORE UPDATE ON alarm BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER alarm_no_delete BEFORE DELETE ON alarm BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER alarm_acknowledged_no_update BEFORE UPDATE ON alarm_acknowledged BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER alarm_acknowledged_no_delete BEFORE DELETE ON alarm_acknowledged BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER certificate_no_update BEFORE UPDATE ON certificate BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER certificate_no_delete BEFORE DELETE ON certificate BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER program_release_no_update BEFORE UPDATE ON program_release BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER program_release_no_delete BEFORE DELETE ON program_release BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER temperature_no_update BEFORE UPDATE ON temperature BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER temperature_no_delete BEFORE DELETE ON temperature BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER run_touches_no_update BEFORE UPDATE ON run_touches BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER run_touches_no_delete BEFORE DELETE ON run_touches BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER calibration_no_update BEFORE UPDATE ON calibration BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE TRIGGER calibration_no_delete BEFORE DELETE ON calibration BEGIN SELECT RAISE(ABORT, 'append-only'); END
CREATE INDEX temperature_by_machine_signal_at ON temperature (machine, signal, at)
INSERT INTO trueloop_schema VALUES ('0006')
