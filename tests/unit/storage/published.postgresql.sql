SET statement_timeout = 0;
SET lock_timeout = 0;
SET idle_in_transaction_session_timeout = 0;
SET client_encoding = 'UTF8';
SET standard_conforming_strings = on;
SELECT pg_catalog.set_config('search_path', '', false);
SET check_function_bodies = false;
SET xmloption = content;
SET client_min_messages = warning;
SET row_security = off;
CREATE FUNCTION public.trueloop_append_only() RETURNS trigger
    LANGUAGE plpgsql
    AS $$ BEGIN RAISE EXCEPTION 'append-only: %', TG_TABLE_NAME; END $$;
SET default_tablespace = '';
SET default_table_access_method = heap;
CREATE TABLE public.account (
    id integer NOT NULL,
    name text NOT NULL,
    display text NOT NULL,
    argon2id text NOT NULL,
    oidc_subject text,
    role text NOT NULL,
    language text NOT NULL,
    created_at text NOT NULL,
    disabled integer NOT NULL,
    version integer NOT NULL,
    unit text DEFAULT 'mm'::text NOT NULL
);
CREATE SEQUENCE public.account_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.account_id_seq OWNED BY public.account.id;
CREATE TABLE public.alarm (
    id integer NOT NULL,
    at text NOT NULL,
    source text NOT NULL,
    code text NOT NULL,
    said text NOT NULL,
    document text NOT NULL,
    machine text NOT NULL,
    part_type text NOT NULL,
    blocks integer NOT NULL
);
CREATE TABLE public.alarm_acknowledged (
    alarm integer NOT NULL,
    at text NOT NULL,
    who text NOT NULL,
    why text NOT NULL
);
CREATE SEQUENCE public.alarm_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.alarm_id_seq OWNED BY public.alarm.id;
CREATE TABLE public.api_key (
    id integer NOT NULL,
    machine text NOT NULL,
    name text NOT NULL,
    key_sha256 text NOT NULL,
    scope text NOT NULL,
    expires_at text NOT NULL,
    ended_at text,
    made_by text NOT NULL,
    created_at text NOT NULL
);
CREATE SEQUENCE public.api_key_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.api_key_id_seq OWNED BY public.api_key.id;
CREATE TABLE public.both_inspections (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    part_type text,
    serial text,
    machine text,
    document text NOT NULL,
    CONSTRAINT both_inspections_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.both_inspections_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.both_inspections_id_seq OWNED BY public.both_inspections.id;
CREATE TABLE public.calibration (
    id integer NOT NULL,
    machine text NOT NULL,
    at text NOT NULL,
    who text NOT NULL,
    document text NOT NULL
);
CREATE SEQUENCE public.calibration_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.calibration_id_seq OWNED BY public.calibration.id;
CREATE TABLE public.certificate (
    id integer NOT NULL,
    part integer NOT NULL,
    at text NOT NULL,
    who text NOT NULL,
    sha256 text NOT NULL,
    verdict text NOT NULL,
    content bytea NOT NULL
);
CREATE SEQUENCE public.certificate_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.certificate_id_seq OWNED BY public.certificate.id;
CREATE TABLE public.cmm_point (
    inspection integer NOT NULL,
    "position" integer NOT NULL,
    name text,
    measured_x_mm double precision,
    measured_y_mm double precision,
    measured_z_mm double precision,
    nominal_x_mm double precision,
    nominal_y_mm double precision,
    nominal_z_mm double precision,
    normal_x double precision,
    normal_y double precision,
    normal_z double precision,
    exact text
);
CREATE TABLE public.correction (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    part_type text,
    serial text,
    edge text,
    program_sha256 text,
    product text,
    document text NOT NULL,
    payload text NOT NULL,
    CONSTRAINT correction_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.correction_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.correction_id_seq OWNED BY public.correction.id;
CREATE TABLE public.cut (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    part_type text,
    serial text,
    stage text,
    edge text,
    correction text,
    document text NOT NULL,
    CONSTRAINT cut_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.cut_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.cut_id_seq OWNED BY public.cut.id;
CREATE TABLE public.edge (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    tool text,
    document text NOT NULL,
    CONSTRAINT edge_supersedes_earlier CHECK ((supersedes < id))
);
CREATE TABLE public.edge_event (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    edge text,
    event text,
    document text NOT NULL,
    CONSTRAINT edge_event_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.edge_event_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.edge_event_id_seq OWNED BY public.edge_event.id;
CREATE SEQUENCE public.edge_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.edge_id_seq OWNED BY public.edge.id;
CREATE TABLE public.event (
    id integer NOT NULL,
    at text NOT NULL,
    who text NOT NULL,
    what text NOT NULL,
    subject text NOT NULL,
    document text NOT NULL
);
CREATE SEQUENCE public.event_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.event_id_seq OWNED BY public.event.id;
CREATE TABLE public.idempotency (
    account text NOT NULL,
    key text NOT NULL,
    request_sha256 text NOT NULL,
    status integer NOT NULL,
    body bytea NOT NULL,
    created_at text NOT NULL
);
CREATE TABLE public.inspection (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    part_type text,
    serial text,
    file_sha256 text,
    document text NOT NULL,
    CONSTRAINT inspection_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.inspection_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.inspection_id_seq OWNED BY public.inspection.id;
CREATE TABLE public.inspection_link (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    cut text,
    document text NOT NULL,
    CONSTRAINT inspection_link_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.inspection_link_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.inspection_link_id_seq OWNED BY public.inspection_link.id;
CREATE TABLE public.machine (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    machine text,
    document text NOT NULL,
    CONSTRAINT machine_supersedes_earlier CHECK ((supersedes < id))
);
CREATE TABLE public.machine_heard (
    machine text NOT NULL,
    at text NOT NULL,
    document text NOT NULL
);
CREATE SEQUENCE public.machine_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.machine_id_seq OWNED BY public.machine.id;
CREATE TABLE public.model_decision (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    verdict text,
    document text NOT NULL,
    CONSTRAINT model_decision_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.model_decision_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.model_decision_id_seq OWNED BY public.model_decision.id;
CREATE TABLE public.model_version (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    machine text,
    parent_sha256 text,
    document text NOT NULL,
    CONSTRAINT model_version_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.model_version_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.model_version_id_seq OWNED BY public.model_version.id;
CREATE TABLE public.order_state (
    "order" text NOT NULL,
    state text NOT NULL,
    machine text NOT NULL,
    changed_at text NOT NULL,
    number integer NOT NULL,
    version integer NOT NULL,
    armed_parts integer NOT NULL
);
CREATE TABLE public.part (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    part_type text,
    serial text,
    document text NOT NULL,
    CONSTRAINT part_supersedes_earlier CHECK ((supersedes < id))
);
CREATE TABLE public.part_cut_with (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    document text NOT NULL,
    CONSTRAINT part_cut_with_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.part_cut_with_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.part_cut_with_id_seq OWNED BY public.part_cut_with.id;
CREATE SEQUENCE public.part_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.part_id_seq OWNED BY public.part.id;
CREATE TABLE public.part_state (
    part integer NOT NULL,
    state text NOT NULL,
    "order" text NOT NULL,
    machine text NOT NULL,
    changed_at text NOT NULL,
    held_why text NOT NULL,
    version integer NOT NULL
);
CREATE TABLE public.part_type (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    part_type text,
    document text NOT NULL,
    CONSTRAINT part_type_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.part_type_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.part_type_id_seq OWNED BY public.part_type.id;
CREATE TABLE public.program (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    program_sha256 text,
    document text NOT NULL,
    CONSTRAINT program_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.program_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.program_id_seq OWNED BY public.program.id;
CREATE TABLE public.program_release (
    program_sha256 text NOT NULL,
    at text NOT NULL,
    who text NOT NULL,
    why text NOT NULL
);
CREATE TABLE public.program_text (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    program_sha256 text,
    document text NOT NULL,
    CONSTRAINT program_text_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.program_text_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.program_text_id_seq OWNED BY public.program_text.id;
CREATE TABLE public.proposal (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    part_type text,
    changes text,
    document text NOT NULL,
    CONSTRAINT proposal_supersedes_earlier CHECK ((supersedes < id))
);
CREATE TABLE public.proposal_decision (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    verdict text,
    document text NOT NULL,
    CONSTRAINT proposal_decision_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.proposal_decision_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.proposal_decision_id_seq OWNED BY public.proposal_decision.id;
CREATE SEQUENCE public.proposal_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.proposal_id_seq OWNED BY public.proposal.id;
CREATE TABLE public.quarantine (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    cut text,
    document text NOT NULL,
    CONSTRAINT quarantine_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.quarantine_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.quarantine_id_seq OWNED BY public.quarantine.id;
CREATE TABLE public.reading (
    inspection integer NOT NULL,
    "position" integer NOT NULL,
    characteristic text,
    quantity text,
    actual double precision,
    nominal double precision,
    lower_limit double precision,
    upper_limit double precision,
    feature text,
    other text,
    axis text,
    place_count bigint,
    place_1_mm double precision,
    place_2_mm double precision,
    place_3_mm double precision,
    repeat bigint,
    standard_u double precision,
    measured_at text,
    temperature_c double precision,
    line bigint,
    side text,
    exact text
);
CREATE TABLE public.run (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    work_order text,
    machine text,
    part_type text,
    serial text,
    document text NOT NULL,
    CONSTRAINT run_supersedes_earlier CHECK ((supersedes < id))
);
CREATE TABLE public.run_fact (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    run text,
    document text NOT NULL,
    CONSTRAINT run_fact_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.run_fact_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.run_fact_id_seq OWNED BY public.run_fact.id;
CREATE SEQUENCE public.run_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.run_id_seq OWNED BY public.run.id;
CREATE TABLE public.run_touches (
    id integer NOT NULL,
    run text NOT NULL,
    at text NOT NULL,
    name text NOT NULL,
    sha256 text NOT NULL,
    content bytea NOT NULL
);
CREATE SEQUENCE public.run_touches_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.run_touches_id_seq OWNED BY public.run_touches.id;
CREATE TABLE public.session (
    id_sha256 text NOT NULL,
    account integer NOT NULL,
    created_at text NOT NULL,
    seen_at text NOT NULL,
    expires_at text NOT NULL,
    ended_at text,
    address text NOT NULL
);
CREATE TABLE public.setting (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    edge text,
    document text NOT NULL,
    CONSTRAINT setting_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.setting_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.setting_id_seq OWNED BY public.setting.id;
CREATE TABLE public.standard_part (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    part_type text,
    serial text,
    document text NOT NULL,
    CONSTRAINT standard_part_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.standard_part_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.standard_part_id_seq OWNED BY public.standard_part.id;
CREATE TABLE public.step (
    "order" text NOT NULL,
    part integer NOT NULL,
    no integer NOT NULL,
    kind text NOT NULL,
    state text NOT NULL,
    run text NOT NULL,
    program_sha256 text NOT NULL,
    changed_at text NOT NULL,
    attempts integer NOT NULL,
    version integer NOT NULL
);
CREATE TABLE public.task (
    id integer NOT NULL,
    kind text NOT NULL,
    subject text NOT NULL,
    state text NOT NULL,
    document text NOT NULL,
    said text NOT NULL,
    lease_until text,
    problem text,
    result text,
    worker text NOT NULL,
    made_by text NOT NULL,
    made_at text NOT NULL,
    changed_at text NOT NULL,
    tries integer NOT NULL,
    progress double precision NOT NULL
);
CREATE SEQUENCE public.task_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.task_id_seq OWNED BY public.task.id;
CREATE TABLE public.temperature (
    id integer NOT NULL,
    machine text NOT NULL,
    run text NOT NULL,
    signal text NOT NULL,
    at text NOT NULL,
    celsius double precision NOT NULL
);
CREATE SEQUENCE public.temperature_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.temperature_id_seq OWNED BY public.temperature.id;
CREATE TABLE public.tool (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    tool text,
    document text NOT NULL,
    CONSTRAINT tool_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.tool_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.tool_id_seq OWNED BY public.tool.id;
CREATE TABLE public.touch (
    inspection integer NOT NULL,
    "position" integer NOT NULL,
    point text,
    feature text,
    nominal_x_mm double precision,
    nominal_z_mm double precision,
    measured_x_mm double precision,
    measured_z_mm double precision,
    error_mm double precision,
    line bigint,
    exact text
);
CREATE TABLE public.transfer (
    id integer NOT NULL,
    at text NOT NULL,
    who text NOT NULL,
    control text NOT NULL,
    program_sha256 text NOT NULL,
    name text NOT NULL,
    direction text NOT NULL,
    sent_sha256 text NOT NULL,
    read_back_sha256 text NOT NULL,
    outcome text NOT NULL,
    document text NOT NULL
);
CREATE SEQUENCE public.transfer_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.transfer_id_seq OWNED BY public.transfer.id;
CREATE TABLE public.trueloop_schema (
    version_num character varying(32) NOT NULL
);
CREATE TABLE public.upload (
    id integer NOT NULL,
    by text NOT NULL,
    name text NOT NULL,
    sha256 text NOT NULL,
    created_at text NOT NULL,
    content bytea NOT NULL
);
CREATE SEQUENCE public.upload_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.upload_id_seq OWNED BY public.upload.id;
CREATE TABLE public.work_order (
    id integer NOT NULL,
    identity text NOT NULL,
    version integer NOT NULL,
    kept_at text NOT NULL,
    kept_by text NOT NULL,
    supersedes integer,
    reason text NOT NULL,
    sha256 text NOT NULL,
    part_type text,
    machine text,
    document text NOT NULL,
    CONSTRAINT work_order_supersedes_earlier CHECK ((supersedes < id))
);
CREATE SEQUENCE public.work_order_id_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.work_order_id_seq OWNED BY public.work_order.id;
ALTER TABLE ONLY public.account ALTER COLUMN id SET DEFAULT nextval('public.account_id_seq'::regclass);
ALTER TABLE ONLY public.alarm ALTER COLUMN id SET DEFAULT nextval('public.alarm_id_seq'::regclass);
ALTER TABLE ONLY public.api_key ALTER COLUMN id SET DEFAULT nextval('public.api_key_id_seq'::regclass);
ALTER TABLE ONLY public.both_inspections ALTER COLUMN id SET DEFAULT nextval('public.both_inspections_id_seq'::regclass);
ALTER TABLE ONLY public.calibration ALTER COLUMN id SET DEFAULT nextval('public.calibration_id_seq'::regclass);
ALTER TABLE ONLY public.certificate ALTER COLUMN id SET DEFAULT nextval('public.certificate_id_seq'::regclass);
ALTER TABLE ONLY public.correction ALTER COLUMN id SET DEFAULT nextval('public.correction_id_seq'::regclass);
ALTER TABLE ONLY public.cut ALTER COLUMN id SET DEFAULT nextval('public.cut_id_seq'::regclass);
ALTER TABLE ONLY public.edge ALTER COLUMN id SET DEFAULT nextval('public.edge_id_seq'::regclass);
ALTER TABLE ONLY public.edge_event ALTER COLUMN id SET DEFAULT nextval('public.edge_event_id_seq'::regclass);
ALTER TABLE ONLY public.event ALTER COLUMN id SET DEFAULT nextval('public.event_id_seq'::regclass);
ALTER TABLE ONLY public.inspection ALTER COLUMN id SET DEFAULT nextval('public.inspection_id_seq'::regclass);
ALTER TABLE ONLY public.inspection_link ALTER COLUMN id SET DEFAULT nextval('public.inspection_link_id_seq'::regclass);
ALTER TABLE ONLY public.machine ALTER COLUMN id SET DEFAULT nextval('public.machine_id_seq'::regclass);
ALTER TABLE ONLY public.model_decision ALTER COLUMN id SET DEFAULT nextval('public.model_decision_id_seq'::regclass);
ALTER TABLE ONLY public.model_version ALTER COLUMN id SET DEFAULT nextval('public.model_version_id_seq'::regclass);
ALTER TABLE ONLY public.part ALTER COLUMN id SET DEFAULT nextval('public.part_id_seq'::regclass);
ALTER TABLE ONLY public.part_cut_with ALTER COLUMN id SET DEFAULT nextval('public.part_cut_with_id_seq'::regclass);
ALTER TABLE ONLY public.part_type ALTER COLUMN id SET DEFAULT nextval('public.part_type_id_seq'::regclass);
ALTER TABLE ONLY public.program ALTER COLUMN id SET DEFAULT nextval('public.program_id_seq'::regclass);
ALTER TABLE ONLY public.program_text ALTER COLUMN id SET DEFAULT nextval('public.program_text_id_seq'::regclass);
ALTER TABLE ONLY public.proposal ALTER COLUMN id SET DEFAULT nextval('public.proposal_id_seq'::regclass);
ALTER TABLE ONLY public.proposal_decision ALTER COLUMN id SET DEFAULT nextval('public.proposal_decision_id_seq'::regclass);
ALTER TABLE ONLY public.quarantine ALTER COLUMN id SET DEFAULT nextval('public.quarantine_id_seq'::regclass);
ALTER TABLE ONLY public.run ALTER COLUMN id SET DEFAULT nextval('public.run_id_seq'::regclass);
ALTER TABLE ONLY public.run_fact ALTER COLUMN id SET DEFAULT nextval('public.run_fact_id_seq'::regclass);
ALTER TABLE ONLY public.run_touches ALTER COLUMN id SET DEFAULT nextval('public.run_touches_id_seq'::regclass);
ALTER TABLE ONLY public.setting ALTER COLUMN id SET DEFAULT nextval('public.setting_id_seq'::regclass);
ALTER TABLE ONLY public.standard_part ALTER COLUMN id SET DEFAULT nextval('public.standard_part_id_seq'::regclass);
ALTER TABLE ONLY public.task ALTER COLUMN id SET DEFAULT nextval('public.task_id_seq'::regclass);
ALTER TABLE ONLY public.temperature ALTER COLUMN id SET DEFAULT nextval('public.temperature_id_seq'::regclass);
ALTER TABLE ONLY public.tool ALTER COLUMN id SET DEFAULT nextval('public.tool_id_seq'::regclass);
ALTER TABLE ONLY public.transfer ALTER COLUMN id SET DEFAULT nextval('public.transfer_id_seq'::regclass);
ALTER TABLE ONLY public.upload ALTER COLUMN id SET DEFAULT nextval('public.upload_id_seq'::regclass);
ALTER TABLE ONLY public.work_order ALTER COLUMN id SET DEFAULT nextval('public.work_order_id_seq'::regclass);
INSERT INTO public.correction VALUES (1, '0123456789abcdef', 1, '2026-11-23T16:34:25.682986+00:00', 'ana', NULL, '', '8c273672699321399ff4f8c4b2f718c550878df65b1be47e3b45d238b0d04d1e', 'shaft', '17', NULL, '2222222222222222222222222222222222222222222222222222222222222222', 'turned', '{"type": "Correction", "record": {"type": "Record", "id": "0123456789abcdef", "made_at": "2026-01-02T03:04:05+00:00", "made_by": "ana", "trueloop_version": "0.1.0", "inputs_sha256": {"job.toml": "0000000000000000000000000000000000000000000000000000000000000000", "touches.csv": "1111111111111111111111111111111111111111111111111111111111111111"}, "options": {"limits": {"correction_mm": 0.15, "slope": 0.04}, "unit": {"unit": "mm", "stated_by": "line 1"}}, "model": {"curves": {"type": "list", "items": [{"feature": "dome"}]}, "scatter_mm": 0.0013, "degrees_of_freedom": 21}, "decision": {"type": "list", "items": ["X: the contour is changed."]}, "changes": {"type": "list", "items": [{"type": "ChangedWord", "line": 3, "column": 5, "before": "X10.", "after": "X9.98"}]}, "components": {"type": "list", "items": [{"type": "Component", "feature": "dome", "point": "20", "comp_mtg_um": -5.0, "comp_proc_um": -73.4, "composed_um": -78.4}]}, "schema": 1, "product": {"type": "Product", "value": "turned"}, "edits": 1, "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "machine": {"type": "Machine", "name": "lathe", "serial": "7", "schema": 1}, "tool": {"type": "Tool", "number": 1, "name": "SVJBR 2020", "corner_radius_mm": 0.8, "radius_mm": null, "schema": 1}, "edge": null, "edge_set_at": null, "program": {"type": "Program", "name": "finish.nc", "dialect": "fanuc-lathe", "sha256": "2222222222222222222222222222222222222222222222222222222222222222", "unit": "mm", "schema": 1}, "inspections": [{"type": "Inspection", "part": {"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "17", "schema": 1}, "measured": "touches", "sha256": "1111111111111111111111111111111111111111111111111111111111111111", "count": 1, "values": [{"type": "Touch", "point": "20", "nominal_mm": [10.0, -5.0], "feature": "dome", "measured_mm": null, "error_mm": 0.0784, "line": 2}], "device": "probe of the machine tool", "operator": "", "frame": "part", "measured_at": {"type": "datetime", "value": "2026-01-02T03:00:00+00:00"}, "ball_radius_mm": 0.0, "z_reference": null, "temperatures": {"bed_C": 21.5}, "schema": 1}], "tool_offset": {"type": "ToolOffset", "tool": 3, "x_radius_mm": -0.012, "z_mm": 0.004, "makes_the_correction": true, "x_is": "diameter", "unit": "mm", "measured_sha256": "1111111111111111111111111111111111111111111111111111111111111111", "held": {"type": "HeldTool", "name": "OD", "edge": 1, "row": {"type": "TableRow", "file": "tool.tbl", "kind": "wear", "x": "-0.1", "z": null, "unit": "mm"}}, "decimals": 4, "blocks": ["G21 G10 P3 U-0.0240 W0.0040"], "schema": 1}, "characteristics": []}, "limits": {"size_mm": 0.15}, "payload": null, "schema": 1}
', 'null
');
INSERT INTO public.cut VALUES (1, 'shaftB17finish2026-01-02T03:04:05.678901+00:00', 1, '2026-11-23T16:34:25.593471+00:00', 'ana', NULL, '', '42234148c58c2c2a279ce6847d9648305a218d8e95b34c34cb9049922acd0edf', 'shaft', '17', 'finish', 'SVJBR 2020VBMT 1604A', '', '{"type": "Cut", "part": {"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "17", "schema": 1}, "stage": {"type": "Stage", "value": "finish"}, "setting": {"type": "Setting", "edge": {"type": "Edge", "tool": {"type": "Tool", "number": 3, "name": "SVJBR 2020", "corner_radius_mm": 0.8, "radius_mm": null, "schema": 1}, "insert": "VBMT 1604", "corner": "A", "schema": 1}, "set_at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "schema": 1}, "machine": {"type": "Machine", "name": "lathe", "serial": "7", "schema": 1}, "program_sha256": "2222222222222222222222222222222222222222222222222222222222222222", "correction": "", "at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "order": null, "order_in_doubt": false, "conditions": {"type": "CuttingConditions", "depth_of_cut_mm": null, "feed_mm_per_rev": null, "speed_m_per_min": null, "time_in_cut_min": null, "material": ""}, "schema": 1}
');
INSERT INTO public.edge VALUES (1, 'SVJBR 2020VBMT 1604A', 1, '2026-11-23T16:34:25.512243+00:00', 'ana', NULL, '', '27053cc238f17675cfb291336105c1544be55a662a831b122fb060b59c1fa8cb', 'SVJBR 2020', '{"type": "Edge", "tool": {"type": "Tool", "number": 3, "name": "SVJBR 2020", "corner_radius_mm": 0.8, "radius_mm": null, "schema": 1}, "insert": "VBMT 1604", "corner": "A", "schema": 1}
');
INSERT INTO public.inspection VALUES (1, '1111111111111111111111111111111111111111111111111111111111111111shaftB172026-01-02T03:04:05.678901+00:00', 1, '2026-11-23T16:34:25.280328+00:00', 'ana', NULL, '', 'b79f6cacb16103ef6f66776f5c418c4246c081d93a7420ef766a66527ed509c9', 'shaft', '17', '1111111111111111111111111111111111111111111111111111111111111111', '{"type": "Inspection", "part": {"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "17", "schema": 1}, "measured": "touches", "sha256": "1111111111111111111111111111111111111111111111111111111111111111", "count": 3, "values": [], "device": "", "operator": "", "frame": "part", "measured_at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "ball_radius_mm": 0.0, "z_reference": null, "temperatures": {}, "schema": 1}
');
INSERT INTO public.inspection VALUES (2, '1111111111111111111111111111111111111111111111111111111111111111shaftB182026-01-02T03:04:05.678901+00:00', 1, '2026-11-23T16:34:25.355939+00:00', 'ana', NULL, '', 'eda771b161a3e4af7a54215950f1bf0b7369d9bb4ba2b270ec7319f6afc6c877', 'shaft', '18', '1111111111111111111111111111111111111111111111111111111111111111', '{"type": "Inspection", "part": {"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "18", "schema": 1}, "measured": "touches", "sha256": "1111111111111111111111111111111111111111111111111111111111111111", "count": 3, "values": [], "device": "", "operator": "", "frame": "part", "measured_at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "ball_radius_mm": 0.0, "z_reference": null, "temperatures": {}, "schema": 1}
');
INSERT INTO public.inspection VALUES (3, '1111111111111111111111111111111111111111111111111111111111111111shaftB182026-01-02T03:04:05.678901+00:00', 2, '2026-11-23T16:34:25.400467+00:00', 'ben', 2, 'probe not calibrated', '06cf4a316b020248eeccdcaa1468808a3cdbb315b7cc75175a5c6d919bfd4674', 'shaft', '18', '1111111111111111111111111111111111111111111111111111111111111111', '{"type": "Inspection", "part": {"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "18", "schema": 1}, "measured": "touches", "sha256": "1111111111111111111111111111111111111111111111111111111111111111", "count": 3, "values": [], "device": "", "operator": "", "frame": "part", "measured_at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "ball_radius_mm": 0.0, "z_reference": null, "temperatures": {}, "schema": 1}
');
INSERT INTO public.inspection_link VALUES (1, '1111111111111111111111111111111111111111111111111111111111111111shaftB172026-01-02T03:04:05.678901+00:00', 1, '2026-11-23T16:34:25.628325+00:00', 'ana', NULL, '', '14846fc42c62f35b713a554bf936672e5b1d9541d9707d82d4d4f5d021644f78', 'shaftB17finish2026-01-02T03:04:05.678901+00:00', '{"type": "InspectionLink", "inspection": ["1111111111111111111111111111111111111111111111111111111111111111", "shaft", "B", "17", "2026-01-02T03:04:05.678901+00:00"], "cut": ["shaft", "B", "17", {"type": "Stage", "value": "finish"}, "2026-01-02T03:04:05.678901+00:00"], "released": false, "schema": 1}
');
INSERT INTO public.machine VALUES (1, 'lathe7', 1, '2026-11-23T16:34:25.564211+00:00', 'ana', NULL, '', '752f77a0bbafeaa4c772c812c2a4aa4d261fb6c842b8e49a012ecaccbcedeb6d', 'lathe', '{"type": "Machine", "name": "lathe", "serial": "7", "schema": 1}
');
INSERT INTO public.part VALUES (1, 'shaftB17', 1, '2026-11-23T16:34:25.254683+00:00', 'ana', NULL, '', 'feafabf17727ede6cec73ecc9e61e6ad9ea14f8a1e4c8e0c6cf5bf5927387dd8', 'shaft', '17', '{"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "17", "schema": 1}
');
INSERT INTO public.part VALUES (2, 'shaftB18', 1, '2026-11-23T16:34:25.323886+00:00', 'ana', NULL, '', '0bc00a1e4d53d45adb1daf27f803a7c199f7f7b4944344d01b5054faef4aa558', 'shaft', '18', '{"type": "Part", "part_type": {"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}, "serial": "18", "schema": 1}
');
INSERT INTO public.part_type VALUES (1, 'shaftB', 1, '2026-11-23T16:34:25.243065+00:00', 'ana', NULL, '', '01d0b3932c2ca5b5f19cda7f4fb43d02888b5029929e8d35448f5ffe0592f246', 'shaft', '{"type": "PartType", "name": "shaft", "revision": "B", "material": "C45", "drawing": "", "schema": 1}
');
INSERT INTO public.program VALUES (1, '2222222222222222222222222222222222222222222222222222222222222222', 1, '2026-11-23T16:34:25.658308+00:00', 'ana', NULL, '', '98d2fa7ec8760d3a5d68baff69b75ac637719e575364b26b8e7383ed87f5dfa0', '2222222222222222222222222222222222222222222222222222222222222222', '{"type": "Program", "name": "finish.nc", "dialect": "fanuc-lathe", "sha256": "2222222222222222222222222222222222222222222222222222222222222222", "unit": "mm", "schema": 1}
');
INSERT INTO public.setting VALUES (1, 'SVJBR 2020VBMT 1604A2026-01-02T03:04:05.678901+00:00', 1, '2026-11-23T16:34:25.537770+00:00', 'ana', NULL, '', 'd3385027f288615a85284380ab76716a05cf4c82f24ad8b95860d9bfc476e228', 'SVJBR 2020VBMT 1604A', '{"type": "Setting", "edge": {"type": "Edge", "tool": {"type": "Tool", "number": 3, "name": "SVJBR 2020", "corner_radius_mm": 0.8, "radius_mm": null, "schema": 1}, "insert": "VBMT 1604", "corner": "A", "schema": 1}, "set_at": {"type": "datetime", "value": "2026-01-02T03:04:05.678901+00:00"}, "schema": 1}
');
INSERT INTO public.tool VALUES (1, 'SVJBR 2020', 1, '2026-11-23T16:34:25.500190+00:00', 'ana', NULL, '', '4e5fbd01c398be9e24226fa53cc8199a3809c9ca4c67bd2da31d270bd4dbc611', 'SVJBR 2020', '{"type": "Tool", "number": 3, "name": "SVJBR 2020", "corner_radius_mm": 0.8, "radius_mm": null, "schema": 1}
');
INSERT INTO public.touch VALUES (1, 0, '0', 'dome', 10, 0, NULL, NULL, 0, 2, NULL);
INSERT INTO public.touch VALUES (1, 1, '1', 'dome', 10.333333333333334, -0.14285714285714285, NULL, NULL, 0.00014285714285714287, 3, NULL);
INSERT INTO public.touch VALUES (1, 2, '2', 'dome', 10.666666666666666, -0.2857142857142857, NULL, NULL, 0.00028571428571428574, 4, NULL);
INSERT INTO public.touch VALUES (2, 0, '0', 'dome', 10, 0, NULL, NULL, 0, 2, NULL);
INSERT INTO public.touch VALUES (2, 1, '1', 'dome', 10.333333333333334, -0.14285714285714285, NULL, NULL, 0.00014285714285714287, 3, NULL);
INSERT INTO public.touch VALUES (2, 2, '2', 'dome', 10.666666666666666, -0.2857142857142857, NULL, NULL, 0.00028571428571428574, 4, NULL);
INSERT INTO public.touch VALUES (3, 0, '0', 'dome', 10, 0, NULL, NULL, 0.001, 2, NULL);
INSERT INTO public.touch VALUES (3, 1, '1', 'dome', 10.333333333333334, -0.14285714285714285, NULL, NULL, 0.001142857142857143, 3, NULL);
INSERT INTO public.touch VALUES (3, 2, '2', 'dome', 10.666666666666666, -0.2857142857142857, NULL, NULL, 0.0012857142857142859, 4, NULL);
INSERT INTO public.trueloop_schema VALUES ('0006');
SELECT pg_catalog.setval('public.account_id_seq', 1, false);
SELECT pg_catalog.setval('public.alarm_id_seq', 1, false);
SELECT pg_catalog.setval('public.api_key_id_seq', 1, false);
SELECT pg_catalog.setval('public.both_inspections_id_seq', 1, false);
SELECT pg_catalog.setval('public.calibration_id_seq', 1, false);
SELECT pg_catalog.setval('public.certificate_id_seq', 1, false);
SELECT pg_catalog.setval('public.correction_id_seq', 1, true);
SELECT pg_catalog.setval('public.cut_id_seq', 1, true);
SELECT pg_catalog.setval('public.edge_event_id_seq', 1, false);
SELECT pg_catalog.setval('public.edge_id_seq', 1, true);
SELECT pg_catalog.setval('public.event_id_seq', 1, false);
SELECT pg_catalog.setval('public.inspection_id_seq', 3, true);
SELECT pg_catalog.setval('public.inspection_link_id_seq', 1, true);
SELECT pg_catalog.setval('public.machine_id_seq', 1, true);
SELECT pg_catalog.setval('public.model_decision_id_seq', 1, false);
SELECT pg_catalog.setval('public.model_version_id_seq', 1, false);
SELECT pg_catalog.setval('public.part_cut_with_id_seq', 1, false);
SELECT pg_catalog.setval('public.part_id_seq', 2, true);
SELECT pg_catalog.setval('public.part_type_id_seq', 1, true);
SELECT pg_catalog.setval('public.program_id_seq', 1, true);
SELECT pg_catalog.setval('public.program_text_id_seq', 1, false);
SELECT pg_catalog.setval('public.proposal_decision_id_seq', 1, false);
SELECT pg_catalog.setval('public.proposal_id_seq', 1, false);
SELECT pg_catalog.setval('public.quarantine_id_seq', 1, false);
SELECT pg_catalog.setval('public.run_fact_id_seq', 1, false);
SELECT pg_catalog.setval('public.run_id_seq', 1, false);
SELECT pg_catalog.setval('public.run_touches_id_seq', 1, false);
SELECT pg_catalog.setval('public.setting_id_seq', 1, true);
SELECT pg_catalog.setval('public.standard_part_id_seq', 1, false);
SELECT pg_catalog.setval('public.task_id_seq', 1, false);
SELECT pg_catalog.setval('public.temperature_id_seq', 1, false);
SELECT pg_catalog.setval('public.tool_id_seq', 1, true);
SELECT pg_catalog.setval('public.transfer_id_seq', 1, false);
SELECT pg_catalog.setval('public.upload_id_seq', 1, false);
SELECT pg_catalog.setval('public.work_order_id_seq', 1, false);
ALTER TABLE ONLY public.account
    ADD CONSTRAINT account_once UNIQUE (name);
ALTER TABLE ONLY public.account
    ADD CONSTRAINT account_once_of_subject UNIQUE (oidc_subject);
ALTER TABLE ONLY public.account
    ADD CONSTRAINT account_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.alarm_acknowledged
    ADD CONSTRAINT alarm_acknowledged_pkey PRIMARY KEY (alarm);
ALTER TABLE ONLY public.alarm
    ADD CONSTRAINT alarm_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.api_key
    ADD CONSTRAINT api_key_once UNIQUE (key_sha256);
ALTER TABLE ONLY public.api_key
    ADD CONSTRAINT api_key_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.both_inspections
    ADD CONSTRAINT both_inspections_once UNIQUE (identity, version);
ALTER TABLE ONLY public.both_inspections
    ADD CONSTRAINT both_inspections_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.both_inspections
    ADD CONSTRAINT both_inspections_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.calibration
    ADD CONSTRAINT calibration_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.certificate
    ADD CONSTRAINT certificate_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.cmm_point
    ADD CONSTRAINT cmm_point_pkey PRIMARY KEY (inspection, "position");
ALTER TABLE ONLY public.correction
    ADD CONSTRAINT correction_once UNIQUE (identity, version);
ALTER TABLE ONLY public.correction
    ADD CONSTRAINT correction_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.correction
    ADD CONSTRAINT correction_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.cut
    ADD CONSTRAINT cut_once UNIQUE (identity, version);
ALTER TABLE ONLY public.cut
    ADD CONSTRAINT cut_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.cut
    ADD CONSTRAINT cut_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.edge_event
    ADD CONSTRAINT edge_event_once UNIQUE (identity, version);
ALTER TABLE ONLY public.edge_event
    ADD CONSTRAINT edge_event_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.edge_event
    ADD CONSTRAINT edge_event_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.edge
    ADD CONSTRAINT edge_once UNIQUE (identity, version);
ALTER TABLE ONLY public.edge
    ADD CONSTRAINT edge_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.edge
    ADD CONSTRAINT edge_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.event
    ADD CONSTRAINT event_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.idempotency
    ADD CONSTRAINT idempotency_pkey PRIMARY KEY (account, key);
ALTER TABLE ONLY public.inspection_link
    ADD CONSTRAINT inspection_link_once UNIQUE (identity, version);
ALTER TABLE ONLY public.inspection_link
    ADD CONSTRAINT inspection_link_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.inspection_link
    ADD CONSTRAINT inspection_link_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.inspection
    ADD CONSTRAINT inspection_once UNIQUE (identity, version);
ALTER TABLE ONLY public.inspection
    ADD CONSTRAINT inspection_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.inspection
    ADD CONSTRAINT inspection_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.machine_heard
    ADD CONSTRAINT machine_heard_pkey PRIMARY KEY (machine);
ALTER TABLE ONLY public.machine
    ADD CONSTRAINT machine_once UNIQUE (identity, version);
ALTER TABLE ONLY public.machine
    ADD CONSTRAINT machine_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.machine
    ADD CONSTRAINT machine_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.model_decision
    ADD CONSTRAINT model_decision_once UNIQUE (identity, version);
ALTER TABLE ONLY public.model_decision
    ADD CONSTRAINT model_decision_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.model_decision
    ADD CONSTRAINT model_decision_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.model_version
    ADD CONSTRAINT model_version_once UNIQUE (identity, version);
ALTER TABLE ONLY public.model_version
    ADD CONSTRAINT model_version_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.model_version
    ADD CONSTRAINT model_version_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.order_state
    ADD CONSTRAINT order_state_pkey PRIMARY KEY ("order");
ALTER TABLE ONLY public.part_cut_with
    ADD CONSTRAINT part_cut_with_once UNIQUE (identity, version);
ALTER TABLE ONLY public.part_cut_with
    ADD CONSTRAINT part_cut_with_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.part_cut_with
    ADD CONSTRAINT part_cut_with_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.part
    ADD CONSTRAINT part_once UNIQUE (identity, version);
ALTER TABLE ONLY public.part
    ADD CONSTRAINT part_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.part_state
    ADD CONSTRAINT part_state_pkey PRIMARY KEY (part);
ALTER TABLE ONLY public.part
    ADD CONSTRAINT part_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.part_type
    ADD CONSTRAINT part_type_once UNIQUE (identity, version);
ALTER TABLE ONLY public.part_type
    ADD CONSTRAINT part_type_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.part_type
    ADD CONSTRAINT part_type_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.program
    ADD CONSTRAINT program_once UNIQUE (identity, version);
ALTER TABLE ONLY public.program
    ADD CONSTRAINT program_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.program_release
    ADD CONSTRAINT program_release_pkey PRIMARY KEY (program_sha256);
ALTER TABLE ONLY public.program
    ADD CONSTRAINT program_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.program_text
    ADD CONSTRAINT program_text_once UNIQUE (identity, version);
ALTER TABLE ONLY public.program_text
    ADD CONSTRAINT program_text_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.program_text
    ADD CONSTRAINT program_text_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.proposal_decision
    ADD CONSTRAINT proposal_decision_once UNIQUE (identity, version);
ALTER TABLE ONLY public.proposal_decision
    ADD CONSTRAINT proposal_decision_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.proposal_decision
    ADD CONSTRAINT proposal_decision_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.proposal
    ADD CONSTRAINT proposal_once UNIQUE (identity, version);
ALTER TABLE ONLY public.proposal
    ADD CONSTRAINT proposal_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.proposal
    ADD CONSTRAINT proposal_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.quarantine
    ADD CONSTRAINT quarantine_once UNIQUE (identity, version);
ALTER TABLE ONLY public.quarantine
    ADD CONSTRAINT quarantine_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.quarantine
    ADD CONSTRAINT quarantine_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.reading
    ADD CONSTRAINT reading_pkey PRIMARY KEY (inspection, "position");
ALTER TABLE ONLY public.run_fact
    ADD CONSTRAINT run_fact_once UNIQUE (identity, version);
ALTER TABLE ONLY public.run_fact
    ADD CONSTRAINT run_fact_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.run_fact
    ADD CONSTRAINT run_fact_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.run
    ADD CONSTRAINT run_once UNIQUE (identity, version);
ALTER TABLE ONLY public.run
    ADD CONSTRAINT run_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.run
    ADD CONSTRAINT run_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.run_touches
    ADD CONSTRAINT run_touches_once UNIQUE (run, sha256);
ALTER TABLE ONLY public.run_touches
    ADD CONSTRAINT run_touches_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.session
    ADD CONSTRAINT session_pkey PRIMARY KEY (id_sha256);
ALTER TABLE ONLY public.setting
    ADD CONSTRAINT setting_once UNIQUE (identity, version);
ALTER TABLE ONLY public.setting
    ADD CONSTRAINT setting_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.setting
    ADD CONSTRAINT setting_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.standard_part
    ADD CONSTRAINT standard_part_once UNIQUE (identity, version);
ALTER TABLE ONLY public.standard_part
    ADD CONSTRAINT standard_part_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.standard_part
    ADD CONSTRAINT standard_part_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.step
    ADD CONSTRAINT step_pkey PRIMARY KEY ("order", part, no);
ALTER TABLE ONLY public.task
    ADD CONSTRAINT task_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.temperature
    ADD CONSTRAINT temperature_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.tool
    ADD CONSTRAINT tool_once UNIQUE (identity, version);
ALTER TABLE ONLY public.tool
    ADD CONSTRAINT tool_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.tool
    ADD CONSTRAINT tool_superseded_once UNIQUE (supersedes);
ALTER TABLE ONLY public.touch
    ADD CONSTRAINT touch_pkey PRIMARY KEY (inspection, "position");
ALTER TABLE ONLY public.transfer
    ADD CONSTRAINT transfer_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.trueloop_schema
    ADD CONSTRAINT trueloop_schema_pkc PRIMARY KEY (version_num);
ALTER TABLE ONLY public.upload
    ADD CONSTRAINT upload_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.work_order
    ADD CONSTRAINT work_order_once UNIQUE (identity, version);
ALTER TABLE ONLY public.work_order
    ADD CONSTRAINT work_order_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.work_order
    ADD CONSTRAINT work_order_superseded_once UNIQUE (supersedes);
CREATE INDEX alarm_by_machine ON public.alarm USING btree (machine);
CREATE INDEX alarm_by_part_type ON public.alarm USING btree (part_type);
CREATE INDEX both_inspections_by_machine ON public.both_inspections USING btree (machine);
CREATE INDEX both_inspections_by_part_type ON public.both_inspections USING btree (part_type);
CREATE INDEX both_inspections_by_serial ON public.both_inspections USING btree (serial, part_type);
CREATE INDEX calibration_by_machine_at ON public.calibration USING btree (machine, at);
CREATE INDEX certificate_by_part ON public.certificate USING btree (part);
CREATE INDEX correction_by_edge ON public.correction USING btree (edge);
CREATE INDEX correction_by_part_type ON public.correction USING btree (part_type);
CREATE INDEX correction_by_product ON public.correction USING btree (product);
CREATE INDEX correction_by_program_sha256 ON public.correction USING btree (program_sha256);
CREATE INDEX correction_by_serial ON public.correction USING btree (serial, part_type);
CREATE INDEX cut_by_correction ON public.cut USING btree (correction);
CREATE INDEX cut_by_edge ON public.cut USING btree (edge);
CREATE INDEX cut_by_part_type ON public.cut USING btree (part_type);
CREATE INDEX cut_by_serial ON public.cut USING btree (serial, part_type);
CREATE INDEX cut_by_stage ON public.cut USING btree (stage);
CREATE INDEX edge_by_tool ON public.edge USING btree (tool);
CREATE INDEX edge_event_by_edge ON public.edge_event USING btree (edge);
CREATE INDEX edge_event_by_event ON public.edge_event USING btree (event);
CREATE INDEX event_by_subject ON public.event USING btree (subject);
CREATE INDEX idempotency_by_created_at ON public.idempotency USING btree (created_at);
CREATE INDEX inspection_by_file_sha256 ON public.inspection USING btree (file_sha256);
CREATE INDEX inspection_by_part_type ON public.inspection USING btree (part_type);
CREATE INDEX inspection_by_serial ON public.inspection USING btree (serial, part_type);
CREATE INDEX inspection_link_by_cut ON public.inspection_link USING btree (cut);
CREATE INDEX machine_by_machine ON public.machine USING btree (machine);
CREATE INDEX model_decision_by_verdict ON public.model_decision USING btree (verdict);
CREATE INDEX model_version_by_machine ON public.model_version USING btree (machine);
CREATE INDEX model_version_by_parent_sha256 ON public.model_version USING btree (parent_sha256);
CREATE INDEX order_state_by_machine_state ON public.order_state USING btree (machine, state);
CREATE INDEX order_state_by_number ON public.order_state USING btree (number);
CREATE INDEX part_by_part_type ON public.part USING btree (part_type);
CREATE INDEX part_by_serial ON public.part USING btree (serial, part_type);
CREATE INDEX part_state_by_changed_at ON public.part_state USING btree (changed_at);
CREATE INDEX part_state_by_order ON public.part_state USING btree ("order");
CREATE INDEX part_state_by_state_part ON public.part_state USING btree (state, part);
CREATE INDEX part_type_by_part_type ON public.part_type USING btree (part_type);
CREATE INDEX program_by_program_sha256 ON public.program USING btree (program_sha256);
CREATE INDEX program_text_by_program_sha256 ON public.program_text USING btree (program_sha256);
CREATE INDEX proposal_by_changes ON public.proposal USING btree (changes);
CREATE INDEX proposal_by_part_type ON public.proposal USING btree (part_type);
CREATE INDEX proposal_decision_by_verdict ON public.proposal_decision USING btree (verdict);
CREATE INDEX quarantine_by_cut ON public.quarantine USING btree (cut);
CREATE INDEX run_by_machine ON public.run USING btree (machine);
CREATE INDEX run_by_part_type ON public.run USING btree (part_type);
CREATE INDEX run_by_serial ON public.run USING btree (serial, part_type);
CREATE INDEX run_by_work_order ON public.run USING btree (work_order);
CREATE INDEX run_fact_by_run ON public.run_fact USING btree (run);
CREATE INDEX session_by_account ON public.session USING btree (account);
CREATE INDEX setting_by_edge ON public.setting USING btree (edge);
CREATE INDEX standard_part_by_part_type ON public.standard_part USING btree (part_type);
CREATE INDEX standard_part_by_serial ON public.standard_part USING btree (serial, part_type);
CREATE INDEX step_by_part ON public.step USING btree (part);
CREATE INDEX step_by_program_sha256 ON public.step USING btree (program_sha256);
CREATE INDEX step_by_run ON public.step USING btree (run);
CREATE INDEX step_by_state_kind ON public.step USING btree (state, kind);
CREATE INDEX task_by_state_id ON public.task USING btree (state, id);
CREATE INDEX task_by_subject ON public.task USING btree (subject);
CREATE INDEX temperature_by_machine_signal_at ON public.temperature USING btree (machine, signal, at);
CREATE INDEX temperature_by_run ON public.temperature USING btree (run);
CREATE INDEX tool_by_tool ON public.tool USING btree (tool);
CREATE INDEX transfer_by_control ON public.transfer USING btree (control);
CREATE INDEX transfer_by_program_sha256 ON public.transfer USING btree (program_sha256);
CREATE INDEX work_order_by_machine ON public.work_order USING btree (machine);
CREATE INDEX work_order_by_part_type ON public.work_order USING btree (part_type);
CREATE TRIGGER alarm_acknowledged_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.alarm_acknowledged FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER alarm_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.alarm FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER both_inspections_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.both_inspections FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER calibration_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.calibration FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER certificate_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.certificate FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER cmm_point_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.cmm_point FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER correction_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.correction FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER cut_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.cut FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER edge_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.edge FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER edge_event_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.edge_event FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER event_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.event FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER inspection_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.inspection FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER inspection_link_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.inspection_link FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER machine_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.machine FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER model_decision_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.model_decision FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER model_version_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.model_version FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER part_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.part FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER part_cut_with_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.part_cut_with FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER part_type_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.part_type FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER program_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.program FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER program_release_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.program_release FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER program_text_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.program_text FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER proposal_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.proposal FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER proposal_decision_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.proposal_decision FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER quarantine_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.quarantine FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER reading_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.reading FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER run_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.run FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER run_fact_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.run_fact FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER run_touches_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.run_touches FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER setting_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.setting FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER standard_part_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.standard_part FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER temperature_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.temperature FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER tool_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.tool FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER touch_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.touch FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER transfer_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.transfer FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
CREATE TRIGGER work_order_append_only BEFORE DELETE OR UPDATE OR TRUNCATE ON public.work_order FOR EACH STATEMENT EXECUTE FUNCTION public.trueloop_append_only();
ALTER TABLE ONLY public.alarm_acknowledged
    ADD CONSTRAINT alarm_acknowledged_alarm_fkey FOREIGN KEY (alarm) REFERENCES public.alarm(id);
ALTER TABLE ONLY public.both_inspections
    ADD CONSTRAINT both_inspections_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.both_inspections(id);
ALTER TABLE ONLY public.certificate
    ADD CONSTRAINT certificate_part_fkey FOREIGN KEY (part) REFERENCES public.part(id);
ALTER TABLE ONLY public.cmm_point
    ADD CONSTRAINT cmm_point_inspection_fkey FOREIGN KEY (inspection) REFERENCES public.inspection(id);
ALTER TABLE ONLY public.correction
    ADD CONSTRAINT correction_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.correction(id);
ALTER TABLE ONLY public.cut
    ADD CONSTRAINT cut_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.cut(id);
ALTER TABLE ONLY public.edge_event
    ADD CONSTRAINT edge_event_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.edge_event(id);
ALTER TABLE ONLY public.edge
    ADD CONSTRAINT edge_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.edge(id);
ALTER TABLE ONLY public.inspection_link
    ADD CONSTRAINT inspection_link_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.inspection_link(id);
ALTER TABLE ONLY public.inspection
    ADD CONSTRAINT inspection_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.inspection(id);
ALTER TABLE ONLY public.machine
    ADD CONSTRAINT machine_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.machine(id);
ALTER TABLE ONLY public.model_decision
    ADD CONSTRAINT model_decision_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.model_decision(id);
ALTER TABLE ONLY public.model_version
    ADD CONSTRAINT model_version_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.model_version(id);
ALTER TABLE ONLY public.part_cut_with
    ADD CONSTRAINT part_cut_with_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.part_cut_with(id);
ALTER TABLE ONLY public.part_state
    ADD CONSTRAINT part_state_part_fkey FOREIGN KEY (part) REFERENCES public.part(id);
ALTER TABLE ONLY public.part
    ADD CONSTRAINT part_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.part(id);
ALTER TABLE ONLY public.part_type
    ADD CONSTRAINT part_type_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.part_type(id);
ALTER TABLE ONLY public.program
    ADD CONSTRAINT program_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.program(id);
ALTER TABLE ONLY public.program_text
    ADD CONSTRAINT program_text_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.program_text(id);
ALTER TABLE ONLY public.proposal_decision
    ADD CONSTRAINT proposal_decision_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.proposal_decision(id);
ALTER TABLE ONLY public.proposal
    ADD CONSTRAINT proposal_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.proposal(id);
ALTER TABLE ONLY public.quarantine
    ADD CONSTRAINT quarantine_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.quarantine(id);
ALTER TABLE ONLY public.reading
    ADD CONSTRAINT reading_inspection_fkey FOREIGN KEY (inspection) REFERENCES public.inspection(id);
ALTER TABLE ONLY public.run_fact
    ADD CONSTRAINT run_fact_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.run_fact(id);
ALTER TABLE ONLY public.run
    ADD CONSTRAINT run_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.run(id);
ALTER TABLE ONLY public.session
    ADD CONSTRAINT session_account_fkey FOREIGN KEY (account) REFERENCES public.account(id);
ALTER TABLE ONLY public.setting
    ADD CONSTRAINT setting_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.setting(id);
ALTER TABLE ONLY public.standard_part
    ADD CONSTRAINT standard_part_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.standard_part(id);
ALTER TABLE ONLY public.step
    ADD CONSTRAINT step_part_fkey FOREIGN KEY (part) REFERENCES public.part(id);
ALTER TABLE ONLY public.tool
    ADD CONSTRAINT tool_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.tool(id);
ALTER TABLE ONLY public.touch
    ADD CONSTRAINT touch_inspection_fkey FOREIGN KEY (inspection) REFERENCES public.inspection(id);
ALTER TABLE ONLY public.work_order
    ADD CONSTRAINT work_order_supersedes_fkey FOREIGN KEY (supersedes) REFERENCES public.work_order(id);
