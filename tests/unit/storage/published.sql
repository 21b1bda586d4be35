BEGIN TRANSACTION;
CREATE TABLE account (
	id INTEGER NOT NULL, 
	name TEXT NOT NULL, 
	display TEXT NOT NULL, 
	argon2id TEXT NOT NULL, 
	oidc_subject TEXT, 
	role TEXT NOT NULL, 
	language TEXT NOT NULL, 
	created_at TEXT NOT NULL, 
	disabled INTEGER NOT NULL, 
	version INTEGER NOT NULL, unit TEXT DEFAULT 'mm' NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT account_once UNIQUE (name), 
	CONSTRAINT account_once_of_subject UNIQUE (oidc_subject)
);
CREATE TABLE alarm (
	id INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	source TEXT NOT NULL, 
	code TEXT NOT NULL, 
	said TEXT NOT NULL, 
	document TEXT NOT NULL, 
	machine TEXT NOT NULL, 
	part_type TEXT NOT NULL, 
	blocks INTEGER NOT NULL, 
	PRIMARY KEY (id)
);
CREATE TABLE alarm_acknowledged (
	alarm INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	who TEXT NOT NULL, 
	why TEXT NOT NULL, 
	PRIMARY KEY (alarm), 
	FOREIGN KEY(alarm) REFERENCES alarm (id)
);
CREATE TABLE api_key (
	id INTEGER NOT NULL, 
	machine TEXT NOT NULL, 
	name TEXT NOT NULL, 
	key_sha256 TEXT NOT NULL, 
	scope TEXT NOT NULL, 
	expires_at TEXT NOT NULL, 
	ended_at TEXT, 
	made_by TEXT NOT NULL, 
	created_at TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT api_key_once UNIQUE (key_sha256)
);
CREATE TABLE both_inspections (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	part_type TEXT, 
	serial TEXT, 
	machine TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT both_inspections_once UNIQUE (identity, version), 
	CONSTRAINT both_inspections_superseded_once UNIQUE (supersedes), 
	CONSTRAINT both_inspections_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES both_inspections (id)
);
CREATE TABLE calibration (
	id INTEGER NOT NULL, 
	machine TEXT NOT NULL, 
	at TEXT NOT NULL, 
	who TEXT NOT NULL, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id)
);
CREATE TABLE certificate (
	id INTEGER NOT NULL, 
	part INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	who TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	verdict TEXT NOT NULL, 
	content BLOB NOT NULL, 
	PRIMARY KEY (id), 
	FOREIGN KEY(part) REFERENCES part (id)
);
CREATE TABLE cmm_point (
	inspection INTEGER NOT NULL, 
	position INTEGER NOT NULL, 
	name TEXT, 
	measured_x_mm DOUBLE, 
	measured_y_mm DOUBLE, 
	measured_z_mm DOUBLE, 
	nominal_x_mm DOUBLE, 
	nominal_y_mm DOUBLE, 
	nominal_z_mm DOUBLE, 
	normal_x DOUBLE, 
	normal_y DOUBLE, 
	normal_z DOUBLE, 
	exact TEXT, 
	PRIMARY KEY (inspection, position), 
	FOREIGN KEY(inspection) REFERENCES inspection (id)
)
 WITHOUT ROWID

;
CREATE TABLE correction (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	part_type TEXT, 
	serial TEXT, 
	edge TEXT, 
	program_sha256 TEXT, 
	product TEXT, 
	document TEXT NOT NULL, 
	payload TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT correction_once UNIQUE (identity, version), 
	CONSTRAINT correction_superseded_once UNIQUE (supersedes), 
	CONSTRAINT correction_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES correction (id)
);
INSERT INTO "correction" VALUES(1,'0123456789abcdef',1,'2026-11-23T16:34:25.682986+00:00','ana',NULL,'','8c273672699321399ff4f8c4b2f718c550878df65b1be47e3b45d238b0d04d1e','shaft','17',NULL,'2222222222222222222222222222222222222222222222222222222222222222','turned','{"type": "Correction", "record": {"type": "Record", "id": "0123456789abcdef", "made_at": "2026-01-02T03:04:05+00:00", "made_by": "ana", "trueloop_version": "0.1.0", "inputs_sha256": {"job.toml": "0000000000000000000000000000000000000000000000000000000000000000", "touches.csv": "1111111111111111111111111111111111111111111111111111111111111111"}, "options": {"limits": {"correction_mm": 0.15, "slope": 0.04}, "unit": {"unit": "mm", "stated_by": "line 1"}}, "model": {"curves": {"type": "list", "items": [{"feature": "dome"}]}, "scatter_mm": 0.0013, "degrees_of_freedom": 21}, "decision": {"type": "list", "items": ["X: the contour is changed."]}, "changes": {"type": "list", "items": [{"type": "ChangedWord", "line": 3, "column": 5, "before": "X10.", "after": "X9.98"}]}, "components": {"type": "list", "items": [{"type": "Component", "feature": "dome", "point": "20", "comp_mtg_um": -5.0, "comp_proc_um": -73.4, "composed_um": -78.4}]}, "schema": 1, "product": {"type": "Product", "value": "turned"}, "edits": 1, "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "machine": {"type": "Machine", "name": "lathe", "serial": "7", "schema": 1}, "tool": {"type": "Tool", "number": 1, "name": "SVJBR 2020", "corner_radius_mm": 0.8, "radius_mm": null, "schema": 1}, "edge": null, "edge_set_at": null, "program": {"type": "Program", "name": "finish.nc", "dialect": "fanuc-lathe", "sha256": "2222222222222222222222222222222222222222222222222222222222222222", "unit": "mm", "schema": 1}, "inspections": [{"type": "Inspection", "part": {"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "17", "schema": 1}, "measured": "touches", "sha256": "1111111111111111111111111111111111111111111111111111111111111111", "count": 1, "values": [{"type": "Touch", "point": "20", "nominal_mm": [10.0, -5.0], "feature": "dome", "measured_mm": null, "error_mm": 0.0784, "line": 2}], "device": "probe of the machine tool", "operator": "", "frame": "part", "measured_at": {"type": "datetime", "value": "2026-01-02T03:00:00+00:00"}, "ball_radius_mm": 0.0, "z_reference": null, "temperatures": {"bed_C": 21.5}, "schema": 1}], "tool_offset": {"type": "ToolOffset", "tool": 3, "x_radius_mm": -0.012, "z_mm": 0.004, "makes_the_correction": true, "x_is": "diameter", "unit": "mm", "measured_sha256": "1111111111111111111111111111111111111111111111111111111111111111", "held": {"type": "HeldTool", "name": "OD", "edge": 1, "row": {"type": "TableRow", "file": "tool.tbl", "kind": "wear", "x": "-0.1", "z": null, "unit": "mm"}}, "decimals": 4, "blocks": ["G21 G10 P3 U-0.0240 W0.0040"], "schema": 1}, "characteristics": []}, "limits": {"size_mm": 0.15}, "payload": null, "schema": 1}
','null
');
CREATE TABLE cut (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	part_type TEXT, 
	serial TEXT, 
	stage TEXT, 
	edge TEXT, 
	correction TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT cut_once UNIQUE (identity, version), 
	CONSTRAINT cut_superseded_once UNIQUE (supersedes), 
	CONSTRAINT cut_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES cut (id)
);
INSERT INTO "cut" VALUES(1,'shaftB17finish2026-01-02T03:04:05.678901+00:00',1,'2026-11-23T16:34:25.593471+00:00','ana',NULL,'','42234148c58c2c2a279ce6847d9648305a218d8e95b34c34cb9049922acd0edf','shaft','17','finish','SVJBR 2020VBMT 1604A','','{"type": "Cut", "part": {"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "17", "schema": 1}, "stage": {"type": "Stage", "value": "finish"}, "setting": {"type": "Setting", "edge": {"type": "Edge", "tool": {"type": "Tool", "number": 3, "name": "SVJBR 2020", "corner_radius_mm": 0.8, "radius_mm": null, "schema": 1}, "insert": "VBMT 1604", "corner": "A", "schema": 1}, "set_at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "schema": 1}, "machine": {"type": "Machine", "name": "lathe", "serial": "7", "schema": 1}, "program_sha256": "2222222222222222222222222222222222222222222222222222222222222222", "correction": "", "at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "order": null, "order_in_doubt": false, "conditions": {"type": "CuttingConditions", "depth_of_cut_mm": null, "feed_mm_per_rev": null, "speed_m_per_min": null, "time_in_cut_min": null, "material": ""}, "schema": 1}
');
CREATE TABLE edge (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	tool TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT edge_once UNIQUE (identity, version), 
	CONSTRAINT edge_superseded_once UNIQUE (supersedes), 
	CONSTRAINT edge_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES edge (id)
);
INSERT INTO "edge" VALUES(1,'SVJBR 2020VBMT 1604A',1,'2026-11-23T16:34:25.512243+00:00','ana',NULL,'','27053cc238f17675cfb291336105c1544be55a662a831b122fb060b59c1fa8cb','SVJBR 2020','{"type": "Edge", "tool": {"type": "Tool", "number": 3, "name": "SVJBR 2020", "corner_radius_mm": 0.8, "radius_mm": null, "schema": 1}, "insert": "VBMT 1604", "corner": "A", "schema": 1}
');
CREATE TABLE edge_event (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	edge TEXT, 
	event TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT edge_event_once UNIQUE (identity, version), 
	CONSTRAINT edge_event_superseded_once UNIQUE (supersedes), 
	CONSTRAINT edge_event_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES edge_event (id)
);
CREATE TABLE event (
	id INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	who TEXT NOT NULL, 
	what TEXT NOT NULL, 
	subject TEXT NOT NULL, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id)
);
CREATE TABLE idempotency (
	account TEXT NOT NULL, 
	"key" TEXT NOT NULL, 
	request_sha256 TEXT NOT NULL, 
	status INTEGER NOT NULL, 
	body BLOB NOT NULL, 
	created_at TEXT NOT NULL, 
	PRIMARY KEY (account, "key")
);
CREATE TABLE inspection (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	part_type TEXT, 
	serial TEXT, 
	file_sha256 TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT inspection_once UNIQUE (identity, version), 
	CONSTRAINT inspection_superseded_once UNIQUE (supersedes), 
	CONSTRAINT inspection_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES inspection (id)
);
INSERT INTO "inspection" VALUES(1,'1111111111111111111111111111111111111111111111111111111111111111shaftB172026-01-02T03:04:05.678901+00:00',1,'2026-11-23T16:34:25.280328+00:00','ana',NULL,'','b79f6cacb16103ef6f66776f5c418c4246c081d93a7420ef766a66527ed509c9','shaft','17','1111111111111111111111111111111111111111111111111111111111111111','{"type": "Inspection", "part": {"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "17", "schema": 1}, "measured": "touches", "sha256": "1111111111111111111111111111111111111111111111111111111111111111", "count": 3, "values": [], "device": "", "operator": "", "frame": "part", "measured_at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "ball_radius_mm": 0.0, "z_reference": null, "temperatures": {}, "schema": 1}
');
INSERT INTO "inspection" VALUES(2,'1111111111111111111111111111111111111111111111111111111111111111shaftB182026-01-02T03:04:05.678901+00:00',1,'2026-11-23T16:34:25.355939+00:00','ana',NULL,'','eda771b161a3e4af7a54215950f1bf0b7369d9bb4ba2b270ec7319f6afc6c877','shaft','18','1111111111111111111111111111111111111111111111111111111111111111','{"type": "Inspection", "part": {"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "18", "schema": 1}, "measured": "touches", "sha256": "1111111111111111111111111111111111111111111111111111111111111111", "count": 3, "values": [], "device": "", "operator": "", "frame": "part", "measured_at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "ball_radius_mm": 0.0, "z_reference": null, "temperatures": {}, "schema": 1}
');
INSERT INTO "inspection" VALUES(3,'1111111111111111111111111111111111111111111111111111111111111111shaftB182026-01-02T03:04:05.678901+00:00',2,'2026-11-23T16:34:25.400467+00:00','ben',2,'probe not calibrated','06cf4a316b020248eeccdcaa1468808a3cdbb315b7cc75175a5c6d919bfd4674','shaft','18','1111111111111111111111111111111111111111111111111111111111111111','{"type": "Inspection", "part": {"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "18", "schema": 1}, "measured": "touches", "sha256": "1111111111111111111111111111111111111111111111111111111111111111", "count": 3, "values": [], "device": "", "operator": "", "frame": "part", "measured_at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "ball_radius_mm": 0.0, "z_reference": null, "temperatures": {}, "schema": 1}
');
CREATE TABLE inspection_link (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	cut TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT inspection_link_once UNIQUE (identity, version), 
	CONSTRAINT inspection_link_superseded_once UNIQUE (supersedes), 
	CONSTRAINT inspection_link_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES inspection_link (id)
);
INSERT INTO "inspection_link" VALUES(1,'1111111111111111111111111111111111111111111111111111111111111111shaftB172026-01-02T03:04:05.678901+00:00',1,'2026-11-23T16:34:25.628325+00:00','ana',NULL,'','14846fc42c62f35b713a554bf936672e5b1d9541d9707d82d4d4f5d021644f78','shaftB17finish2026-01-02T03:04:05.678901+00:00','{"type": "InspectionLink", "inspection": ["1111111111111111111111111111111111111111111111111111111111111111", "shaft", "B", "17", "2026-01-02T03:04:05.678901+00:00"], "cut": ["shaft", "B", "17", {"type": "Stage", "value": "finish"}, "2026-01-02T03:04:05.678901+00:00"], "released": false, "schema": 1}
');
CREATE TABLE machine (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	machine TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT machine_once UNIQUE (identity, version), 
	CONSTRAINT machine_superseded_once UNIQUE (supersedes), 
	CONSTRAINT machine_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES machine (id)
);
INSERT INTO "machine" VALUES(1,'lathe7',1,'2026-11-23T16:34:25.564211+00:00','ana',NULL,'','752f77a0bbafeaa4c772c812c2a4aa4d261fb6c842b8e49a012ecaccbcedeb6d','lathe','{"type": "Machine", "name": "lathe", "serial": "7", "schema": 1}
');
CREATE TABLE machine_heard (
	machine TEXT NOT NULL, 
	at TEXT NOT NULL, 
	document TEXT NOT NULL, 
	PRIMARY KEY (machine)
);
CREATE TABLE model_decision (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	verdict TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT model_decision_once UNIQUE (identity, version), 
	CONSTRAINT model_decision_superseded_once UNIQUE (supersedes), 
	CONSTRAINT model_decision_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES model_decision (id)
);
CREATE TABLE model_version (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	machine TEXT, 
	parent_sha256 TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT model_version_once UNIQUE (identity, version), 
	CONSTRAINT model_version_superseded_once UNIQUE (supersedes), 
	CONSTRAINT model_version_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES model_version (id)
);
CREATE TABLE order_state (
	"order" TEXT NOT NULL, 
	state TEXT NOT NULL, 
	machine TEXT NOT NULL, 
	changed_at TEXT NOT NULL, 
	number INTEGER NOT NULL, 
	version INTEGER NOT NULL, 
	armed_parts INTEGER NOT NULL, 
	PRIMARY KEY ("order")
);
CREATE TABLE part (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	part_type TEXT, 
	serial TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT part_once UNIQUE (identity, version), 
	CONSTRAINT part_superseded_once UNIQUE (supersedes), 
	CONSTRAINT part_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES part (id)
);
INSERT INTO "part" VALUES(1,'shaftB17',1,'2026-11-23T16:34:25.254683+00:00','ana',NULL,'','feafabf17727ede6cec73ecc9e61e6ad9ea14f8a1e4c8e0c6cf5bf5927387dd8','shaft','17','{"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "17", "schema": 1}
');
INSERT INTO "part" VALUES(2,'shaftB18',1,'2026-11-23T16:34:25.323886+00:00','ana',NULL,'','0bc00a1e4d53d45adb1daf27f803a7c199f7f7b4944344d01b5054faef4aa558','shaft','18','{"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "18", "schema": 1}
');
CREATE TABLE part_cut_with (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT part_cut_with_once UNIQUE (identity, version), 
	CONSTRAINT part_cut_with_superseded_once UNIQUE (supersedes), 
	CONSTRAINT part_cut_with_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES part_cut_with (id)
);
CREATE TABLE part_state (
	part INTEGER NOT NULL, 
	state TEXT NOT NULL, 
	"order" TEXT NOT NULL, 
	machine TEXT NOT NULL, 
	changed_at TEXT NOT NULL, 
	held_why TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	PRIMARY KEY (part), 
	FOREIGN KEY(part) REFERENCES part (id)
);
CREATE TABLE part_type (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	part_type TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT part_type_once UNIQUE (identity, version), 
	CONSTRAINT part_type_superseded_once UNIQUE (supersedes), 
	CONSTRAINT part_type_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES part_type (id)
);
INSERT INTO "part_type" VALUES(1,'shaftB',1,'2026-11-23T16:34:25.243065+00:00','ana',NULL,'','01d0b3932c2ca5b5f19cda7f4fb43d02888b5029929e8d35448f5ffe0592f246','shaft','{"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}
');
CREATE TABLE program (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	program_sha256 TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT program_once UNIQUE (identity, version), 
	CONSTRAINT program_superseded_once UNIQUE (supersedes), 
	CONSTRAINT program_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES program (id)
);
INSERT INTO "program" VALUES(1,'2222222222222222222222222222222222222222222222222222222222222222',1,'2026-11-23T16:34:25.658308+00:00','ana',NULL,'','98d2fa7ec8760d3a5d68baff69b75ac637719e575364b26b8e7383ed87f5dfa0','2222222222222222222222222222222222222222222222222222222222222222','{"type": "Program", "name": "finish.nc", "dialect": "fanuc-lathe", "sha256": "2222222222222222222222222222222222222222222222222222222222222222", "unit": "mm", "schema": 1}
');
CREATE TABLE program_release (
	program_sha256 TEXT NOT NULL, 
	at TEXT NOT NULL, 
	who TEXT NOT NULL, 
	why TEXT NOT NULL, 
	PRIMARY KEY (program_sha256)
);
CREATE TABLE program_text (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	program_sha256 TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT program_text_once UNIQUE (identity, version), 
	CONSTRAINT program_text_superseded_once UNIQUE (supersedes), 
	CONSTRAINT program_text_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES program_text (id)
);
CREATE TABLE proposal (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	part_type TEXT, 
	changes TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT proposal_once UNIQUE (identity, version), 
	CONSTRAINT proposal_superseded_once UNIQUE (supersedes), 
	CONSTRAINT proposal_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES proposal (id)
);
CREATE TABLE proposal_decision (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	verdict TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT proposal_decision_once UNIQUE (identity, version), 
	CONSTRAINT proposal_decision_superseded_once UNIQUE (supersedes), 
	CONSTRAINT proposal_decision_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES proposal_decision (id)
);
CREATE TABLE quarantine (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	cut TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT quarantine_once UNIQUE (identity, version), 
	CONSTRAINT quarantine_superseded_once UNIQUE (supersedes), 
	CONSTRAINT quarantine_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES quarantine (id)
);
CREATE TABLE reading (
	inspection INTEGER NOT NULL, 
	position INTEGER NOT NULL, 
	characteristic TEXT, 
	quantity TEXT, 
	actual DOUBLE, 
	nominal DOUBLE, 
	lower_limit DOUBLE, 
	upper_limit DOUBLE, 
	feature TEXT, 
	other TEXT, 
	axis TEXT, 
	place_count BIGINT, 
	place_1_mm DOUBLE, 
	place_2_mm DOUBLE, 
	place_3_mm DOUBLE, 
	repeat BIGINT, 
	standard_u DOUBLE, 
	measured_at TEXT, 
	temperature_c DOUBLE, 
	line BIGINT, 
	side TEXT, 
	exact TEXT, 
	PRIMARY KEY (inspection, position), 
	FOREIGN KEY(inspection) REFERENCES inspection (id)
)
 WITHOUT ROWID

;
CREATE TABLE run (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	work_order TEXT, 
	machine TEXT, 
	part_type TEXT, 
	serial TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT run_once UNIQUE (identity, version), 
	CONSTRAINT run_superseded_once UNIQUE (supersedes), 
	CONSTRAINT run_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES run (id)
);
CREATE TABLE run_fact (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	run TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT run_fact_once UNIQUE (identity, version), 
	CONSTRAINT run_fact_superseded_once UNIQUE (supersedes), 
	CONSTRAINT run_fact_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES run_fact (id)
);
CREATE TABLE run_touches (
	id INTEGER NOT NULL, 
	run TEXT NOT NULL, 
	at TEXT NOT NULL, 
	name TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	content BLOB NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT run_touches_once UNIQUE (run, sha256)
);
CREATE TABLE session (
	id_sha256 TEXT NOT NULL, 
	account INTEGER NOT NULL, 
	created_at TEXT NOT NULL, 
	seen_at TEXT NOT NULL, 
	expires_at TEXT NOT NULL, 
	ended_at TEXT, 
	address TEXT NOT NULL, 
	PRIMARY KEY (id_sha256), 
	FOREIGN KEY(account) REFERENCES account (id)
);
CREATE TABLE setting (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	edge TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT setting_once UNIQUE (identity, version), 
	CONSTRAINT setting_superseded_once UNIQUE (supersedes), 
	CONSTRAINT setting_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES setting (id)
);
INSERT INTO "setting" VALUES(1,'SVJBR 2020VBMT 1604A2026-01-02T03:04:05.678901+00:00',1,'2026-11-23T16:34:25.537770+00:00','ana',NULL,'','d3385027f288615a85284380ab76716a05cf4c82f24ad8b95860d9bfc476e228','SVJBR 2020VBMT 1604A','{"type": "Setting", "edge": {"type": "Edge", "tool": {"type": "Tool", "number": 3, "name": "SVJBR 2020", "corner_radius_mm": 0.8, "radius_mm": null, "schema": 1}, "insert": "VBMT 1604", "corner": "A", "schema": 1}, "set_at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "schema": 1}
');
CREATE TABLE standard_part (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	part_type TEXT, 
	serial TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT standard_part_once UNIQUE (identity, version), 
	CONSTRAINT standard_part_superseded_once UNIQUE (supersedes), 
	CONSTRAINT standard_part_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES standard_part (id)
);
CREATE TABLE step (
	"order" TEXT NOT NULL, 
	part INTEGER NOT NULL, 
	no INTEGER NOT NULL, 
	kind TEXT NOT NULL, 
	state TEXT NOT NULL, 
	run TEXT NOT NULL, 
	program_sha256 TEXT NOT NULL, 
	changed_at TEXT NOT NULL, 
	attempts INTEGER NOT NULL, 
	version INTEGER NOT NULL, 
	PRIMARY KEY ("order", part, no), 
	FOREIGN KEY(part) REFERENCES part (id)
);
CREATE TABLE task (
	id INTEGER NOT NULL, 
	kind TEXT NOT NULL, 
	subject TEXT NOT NULL, 
	state TEXT NOT NULL, 
	document TEXT NOT NULL, 
	said TEXT NOT NULL, 
	lease_until TEXT, 
	problem TEXT, 
	result TEXT, 
	worker TEXT NOT NULL, 
	made_by TEXT NOT NULL, 
	made_at TEXT NOT NULL, 
	changed_at TEXT NOT NULL, 
	tries INTEGER NOT NULL, 
	progress DOUBLE NOT NULL, 
	PRIMARY KEY (id)
);
CREATE TABLE temperature (
	id INTEGER NOT NULL, 
	machine TEXT NOT NULL, 
	run TEXT NOT NULL, 
	signal TEXT NOT NULL, 
	at TEXT NOT NULL, 
	celsius DOUBLE NOT NULL, 
	PRIMARY KEY (id)
);
CREATE TABLE tool (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	tool TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT tool_once UNIQUE (identity, version), 
	CONSTRAINT tool_superseded_once UNIQUE (supersedes), 
	CONSTRAINT tool_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES tool (id)
);
INSERT INTO "tool" VALUES(1,'SVJBR 2020',1,'2026-11-23T16:34:25.500190+00:00','ana',NULL,'','4e5fbd01c398be9e24226fa53cc8199a3809c9ca4c67bd2da31d270bd4dbc611','SVJBR 2020','{"type": "Tool", "number": 3, "name": "SVJBR 2020", "corner_radius_mm": 0.8, "radius_mm": null, "schema": 1}
');
CREATE TABLE touch (
	inspection INTEGER NOT NULL, 
	position INTEGER NOT NULL, 
	point TEXT, 
	feature TEXT, 
	nominal_x_mm DOUBLE, 
	nominal_z_mm DOUBLE, 
	measured_x_mm DOUBLE, 
	measured_z_mm DOUBLE, 
	error_mm DOUBLE, 
	line BIGINT, 
	exact TEXT, 
	PRIMARY KEY (inspection, position), 
	FOREIGN KEY(inspection) REFERENCES inspection (id)
)
 WITHOUT ROWID

;
INSERT INTO "touch" VALUES(1,0,'0','dome',10.0,0.0,NULL,NULL,0.0,2,NULL);
INSERT INTO "touch" VALUES(1,1,'1','dome',1.0333333333333333925e+01,-1.42857142857142849212e-01,NULL,NULL,1.4285714285714286786e-04,3,NULL);
INSERT INTO "touch" VALUES(1,2,'2','dome',1.06666666666666660741e+01,-2.85714285714285698425e-01,NULL,NULL,2.85714285714285735721e-04,4,NULL);
INSERT INTO "touch" VALUES(2,0,'0','dome',10.0,0.0,NULL,NULL,0.0,2,NULL);
INSERT INTO "touch" VALUES(2,1,'1','dome',1.0333333333333333925e+01,-1.42857142857142849212e-01,NULL,NULL,1.4285714285714286786e-04,3,NULL);
INSERT INTO "touch" VALUES(2,2,'2','dome',1.06666666666666660741e+01,-2.85714285714285698425e-01,NULL,NULL,2.85714285714285735721e-04,4,NULL);
INSERT INTO "touch" VALUES(3,0,'0','dome',10.0,0.0,NULL,NULL,0.001,2,NULL);
INSERT INTO "touch" VALUES(3,1,'1','dome',1.0333333333333333925e+01,-1.42857142857142849212e-01,NULL,NULL,1.14285714285714294288e-03,3,NULL);
INSERT INTO "touch" VALUES(3,2,'2','dome',1.06666666666666660741e+01,-2.85714285714285698425e-01,NULL,NULL,1.28571428571428586495e-03,4,NULL);
CREATE TABLE transfer (
	id INTEGER NOT NULL, 
	at TEXT NOT NULL, 
	who TEXT NOT NULL, 
	control TEXT NOT NULL, 
	program_sha256 TEXT NOT NULL, 
	name TEXT NOT NULL, 
	direction TEXT NOT NULL, 
	sent_sha256 TEXT NOT NULL, 
	read_back_sha256 TEXT NOT NULL, 
	outcome TEXT NOT NULL, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id)
);
CREATE TABLE trueloop_schema (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT trueloop_schema_pkc PRIMARY KEY (version_num)
);
INSERT INTO "trueloop_schema" VALUES('0006');
CREATE TABLE upload (
	id INTEGER NOT NULL, 
	"by" TEXT NOT NULL, 
	name TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	created_at TEXT NOT NULL, 
	content BLOB NOT NULL, 
	PRIMARY KEY (id)
);
CREATE TABLE work_order (
	id INTEGER NOT NULL, 
	identity TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	kept_at TEXT NOT NULL, 
	kept_by TEXT NOT NULL, 
	supersedes INTEGER, 
	reason TEXT NOT NULL, 
	sha256 TEXT NOT NULL, 
	part_type TEXT, 
	machine TEXT, 
	document TEXT NOT NULL, 
	PRIMARY KEY (id), 
	CONSTRAINT work_order_once UNIQUE (identity, version), 
	CONSTRAINT work_order_superseded_once UNIQUE (supersedes), 
	CONSTRAINT work_order_supersedes_earlier CHECK (supersedes < id), 
	FOREIGN KEY(supersedes) REFERENCES work_order (id)
);
CREATE INDEX part_type_by_part_type ON part_type (part_type);
CREATE INDEX part_by_part_type ON part (part_type);
CREATE INDEX part_by_serial ON part (serial, part_type);
CREATE INDEX machine_by_machine ON machine (machine);
CREATE INDEX tool_by_tool ON tool (tool);
CREATE INDEX edge_by_tool ON edge (tool);
CREATE INDEX setting_by_edge ON setting (edge);
CREATE INDEX program_by_program_sha256 ON program (program_sha256);
CREATE INDEX program_text_by_program_sha256 ON program_text (program_sha256);
CREATE INDEX cut_by_part_type ON cut (part_type);
CREATE INDEX cut_by_serial ON cut (serial, part_type);
CREATE INDEX cut_by_stage ON cut (stage);
CREATE INDEX cut_by_edge ON cut (edge);
CREATE INDEX cut_by_correction ON cut (correction);
CREATE INDEX inspection_by_part_type ON inspection (part_type);
CREATE INDEX inspection_by_serial ON inspection (serial, part_type);
CREATE INDEX inspection_by_file_sha256 ON inspection (file_sha256);
CREATE INDEX inspection_link_by_cut ON inspection_link (cut);
CREATE INDEX quarantine_by_cut ON quarantine (cut);
CREATE INDEX edge_event_by_edge ON edge_event (edge);
CREATE INDEX edge_event_by_event ON edge_event (event);
CREATE INDEX correction_by_part_type ON correction (part_type);
CREATE INDEX correction_by_serial ON correction (serial, part_type);
CREATE INDEX correction_by_edge ON correction (edge);
CREATE INDEX correction_by_program_sha256 ON correction (program_sha256);
CREATE INDEX correction_by_product ON correction (product);
CREATE INDEX proposal_by_part_type ON proposal (part_type);
CREATE INDEX proposal_by_changes ON proposal (changes);
CREATE INDEX proposal_decision_by_verdict ON proposal_decision (verdict);
CREATE TRIGGER part_type_no_update BEFORE UPDATE ON part_type BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER part_type_no_delete BEFORE DELETE ON part_type BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER part_no_update BEFORE UPDATE ON part BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER part_no_delete BEFORE DELETE ON part BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER machine_no_update BEFORE UPDATE ON machine BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER machine_no_delete BEFORE DELETE ON machine BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER tool_no_update BEFORE UPDATE ON tool BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER tool_no_delete BEFORE DELETE ON tool BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER edge_no_update BEFORE UPDATE ON edge BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER edge_no_delete BEFORE DELETE ON edge BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER setting_no_update BEFORE UPDATE ON setting BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER setting_no_delete BEFORE DELETE ON setting BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER program_no_update BEFORE UPDATE ON program BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER program_no_delete BEFORE DELETE ON program BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER program_text_no_update BEFORE UPDATE ON program_text BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER program_text_no_delete BEFORE DELETE ON program_text BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER cut_no_update BEFORE UPDATE ON cut BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER cut_no_delete BEFORE DELETE ON cut BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER inspection_no_update BEFORE UPDATE ON inspection BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER inspection_no_delete BEFORE DELETE ON inspection BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER inspection_link_no_update BEFORE UPDATE ON inspection_link BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER inspection_link_no_delete BEFORE DELETE ON inspection_link BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER quarantine_no_update BEFORE UPDATE ON quarantine BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER quarantine_no_delete BEFORE DELETE ON quarantine BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER edge_event_no_update BEFORE UPDATE ON edge_event BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER edge_event_no_delete BEFORE DELETE ON edge_event BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER correction_no_update BEFORE UPDATE ON correction BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER correction_no_delete BEFORE DELETE ON correction BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER proposal_no_update BEFORE UPDATE ON proposal BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER proposal_no_delete BEFORE DELETE ON proposal BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER proposal_decision_no_update BEFORE UPDATE ON proposal_decision BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER proposal_decision_no_delete BEFORE DELETE ON proposal_decision BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER part_cut_with_no_update BEFORE UPDATE ON part_cut_with BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER part_cut_with_no_delete BEFORE DELETE ON part_cut_with BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER touch_no_update BEFORE UPDATE ON touch BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER touch_no_delete BEFORE DELETE ON touch BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER reading_no_update BEFORE UPDATE ON reading BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER reading_no_delete BEFORE DELETE ON reading BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER cmm_point_no_update BEFORE UPDATE ON cmm_point BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER cmm_point_no_delete BEFORE DELETE ON cmm_point BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE INDEX both_inspections_by_part_type ON both_inspections (part_type);
CREATE INDEX both_inspections_by_serial ON both_inspections (serial, part_type);
CREATE INDEX both_inspections_by_machine ON both_inspections (machine);
CREATE INDEX model_version_by_machine ON model_version (machine);
CREATE INDEX model_version_by_parent_sha256 ON model_version (parent_sha256);
CREATE INDEX model_decision_by_verdict ON model_decision (verdict);
CREATE INDEX standard_part_by_part_type ON standard_part (part_type);
CREATE INDEX standard_part_by_serial ON standard_part (serial, part_type);
CREATE TRIGGER both_inspections_no_update BEFORE UPDATE ON both_inspections BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER both_inspections_no_delete BEFORE DELETE ON both_inspections BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER model_version_no_update BEFORE UPDATE ON model_version BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER model_version_no_delete BEFORE DELETE ON model_version BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER model_decision_no_update BEFORE UPDATE ON model_decision BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER model_decision_no_delete BEFORE DELETE ON model_decision BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER standard_part_no_update BEFORE UPDATE ON standard_part BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER standard_part_no_delete BEFORE DELETE ON standard_part BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE INDEX work_order_by_part_type ON work_order (part_type);
CREATE INDEX work_order_by_machine ON work_order (machine);
CREATE INDEX run_by_work_order ON run (work_order);
CREATE INDEX run_by_machine ON run (machine);
CREATE INDEX run_by_part_type ON run (part_type);
CREATE INDEX run_by_serial ON run (serial, part_type);
CREATE INDEX run_fact_by_run ON run_fact (run);
CREATE INDEX event_by_subject ON event (subject);
CREATE INDEX transfer_by_control ON transfer (control);
CREATE INDEX transfer_by_program_sha256 ON transfer (program_sha256);
CREATE INDEX alarm_by_machine ON alarm (machine);
CREATE INDEX alarm_by_part_type ON alarm (part_type);
CREATE INDEX certificate_by_part ON certificate (part);
CREATE INDEX temperature_by_run ON temperature (run);
CREATE INDEX calibration_by_machine_at ON calibration (machine, at);
CREATE INDEX order_state_by_machine_state ON order_state (machine, state);
CREATE INDEX order_state_by_number ON order_state (number);
CREATE INDEX part_state_by_order ON part_state ("order");
CREATE INDEX part_state_by_state_part ON part_state (state, part);
CREATE INDEX part_state_by_changed_at ON part_state (changed_at);
CREATE INDEX step_by_part ON step (part);
CREATE INDEX step_by_run ON step (run);
CREATE INDEX step_by_state_kind ON step (state, kind);
CREATE INDEX step_by_program_sha256 ON step (program_sha256);
CREATE INDEX task_by_state_id ON task (state, id);
CREATE INDEX task_by_subject ON task (subject);
CREATE INDEX session_by_account ON session (account);
CREATE INDEX idempotency_by_created_at ON idempotency (created_at);
CREATE TRIGGER work_order_no_update BEFORE UPDATE ON work_order BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER work_order_no_delete BEFORE DELETE ON work_order BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER run_no_update BEFORE UPDATE ON run BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER run_no_delete BEFORE DELETE ON run BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER run_fact_no_update BEFORE UPDATE ON run_fact BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER run_fact_no_delete BEFORE DELETE ON run_fact BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER event_no_update BEFORE UPDATE ON event BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER event_no_delete BEFORE DELETE ON event BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER transfer_no_update BEFORE UPDATE ON transfer BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER transfer_no_delete BEFORE DELETE ON transfer BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER alarm_no_update BEFORE UPDATE ON alarm BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER alarm_no_delete BEFORE DELETE ON alarm BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER alarm_acknowledged_no_update BEFORE UPDATE ON alarm_acknowledged BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER alarm_acknowledged_no_delete BEFORE DELETE ON alarm_acknowledged BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER certificate_no_update BEFORE UPDATE ON certificate BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER certificate_no_delete BEFORE DELETE ON certificate BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER program_release_no_update BEFORE UPDATE ON program_release BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER program_release_no_delete BEFORE DELETE ON program_release BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER temperature_no_update BEFORE UPDATE ON temperature BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER temperature_no_delete BEFORE DELETE ON temperature BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER run_touches_no_update BEFORE UPDATE ON run_touches BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER run_touches_no_delete BEFORE DELETE ON run_touches BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER calibration_no_update BEFORE UPDATE ON calibration BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE TRIGGER calibration_no_delete BEFORE DELETE ON calibration BEGIN SELECT RAISE(ABORT, 'append-only'); END;
CREATE INDEX temperature_by_machine_signal_at ON temperature (machine, signal, at);
COMMIT;
