-- A store of the first schema with one of everything, as pg_dump --inserts writes it; made once, never again.
CREATE TABLE public.alembic_version (
    version_num character varying(32) NOT NULL
);
CREATE TABLE public.artifacts (
    sweep_id character varying(32) NOT NULL,
    name character varying(64) NOT NULL,
    path text NOT NULL,
    size bigint NOT NULL,
    sha256 character varying(64) NOT NULL
);
CREATE TABLE public.dispatchers (
    epoch integer NOT NULL,
    owner text NOT NULL,
    started timestamp with time zone NOT NULL
);
CREATE SEQUENCE public.dispatchers_epoch_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.dispatchers_epoch_seq OWNED BY public.dispatchers.epoch;
CREATE TABLE public.events (
    number integer NOT NULL,
    "time" timestamp with time zone NOT NULL,
    kind character varying(16) NOT NULL,
    sweep_id character varying(32),
    job_id character varying(32),
    body json NOT NULL
);
CREATE SEQUENCE public.events_number_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.events_number_seq OWNED BY public.events.number;
CREATE TABLE public.jobs (
    id character varying(32) NOT NULL,
    kind character varying(16) NOT NULL,
    sweep_id character varying(32),
    scenario text,
    spec json,
    state character varying(16) NOT NULL,
    priority integer NOT NULL,
    ordinal integer NOT NULL,
    cost double precision NOT NULL,
    attempt integer NOT NULL,
    epoch integer NOT NULL,
    token character varying(16),
    crashes integer NOT NULL,
    fraction double precision,
    progress json,
    cause character varying(16),
    failure text,
    reason text,
    summary json,
    path text,
    size bigint,
    sha256 character varying(64),
    seconds double precision,
    created timestamp with time zone NOT NULL,
    queued timestamp with time zone NOT NULL,
    started timestamp with time zone,
    finished timestamp with time zone
);
CREATE TABLE public.points (
    sweep_id character varying(32) NOT NULL,
    ordinal integer NOT NULL,
    run_id character varying(32) NOT NULL,
    place json NOT NULL,
    coordinates json NOT NULL,
    detached boolean NOT NULL
);
CREATE TABLE public.sweeps (
    number integer NOT NULL,
    id character varying(32) NOT NULL,
    name text NOT NULL,
    title text NOT NULL,
    scenario text NOT NULL,
    document json NOT NULL,
    digest character varying(64) NOT NULL,
    planned integer NOT NULL,
    new integer NOT NULL,
    created timestamp with time zone NOT NULL,
    cancelled timestamp with time zone
);
CREATE SEQUENCE public.sweeps_number_seq
    AS integer
    START WITH 1
    INCREMENT BY 1
    NO MINVALUE
    NO MAXVALUE
    CACHE 1;
ALTER SEQUENCE public.sweeps_number_seq OWNED BY public.sweeps.number;
ALTER TABLE ONLY public.dispatchers ALTER COLUMN epoch SET DEFAULT nextval('public.dispatchers_epoch_seq'::regclass);
ALTER TABLE ONLY public.events ALTER COLUMN number SET DEFAULT nextval('public.events_number_seq'::regclass);
ALTER TABLE ONLY public.sweeps ALTER COLUMN number SET DEFAULT nextval('public.sweeps_number_seq'::regclass);
INSERT INTO public.alembic_version VALUES ('0001');
INSERT INTO public.artifacts VALUES ('2b086671db4d4a678d9b1a7691041f9f', 'cube.nc', 'sweeps/2b086671db4d4a678d9b1a7691041f9f/1-abcdef01/cube.nc', 3, '2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO public.artifacts VALUES ('2b086671db4d4a678d9b1a7691041f9f', 'report.html', 'sweeps/2b086671db4d4a678d9b1a7691041f9f/1-abcdef01/report.html', 3, '2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO public.artifacts VALUES ('2b086671db4d4a678d9b1a7691041f9f', 'report.json', 'sweeps/2b086671db4d4a678d9b1a7691041f9f/1-abcdef01/report.json', 3, '2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO public.artifacts VALUES ('c069bfba13234ad8bd27ef4f207e15c6', 'cube.nc', 'sweeps/c069bfba13234ad8bd27ef4f207e15c6/1-abcdef01/cube.nc', 3, '2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO public.artifacts VALUES ('c069bfba13234ad8bd27ef4f207e15c6', 'report.html', 'sweeps/c069bfba13234ad8bd27ef4f207e15c6/1-abcdef01/report.html', 3, '2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO public.artifacts VALUES ('c069bfba13234ad8bd27ef4f207e15c6', 'report.json', 'sweeps/c069bfba13234ad8bd27ef4f207e15c6/1-abcdef01/report.json', 3, '2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO public.dispatchers VALUES (1, 'old:1', '2026-11-21 10:22:49.745803+00');
INSERT INTO public.dispatchers VALUES (2, 'old:2', '2026-11-21 10:22:49.909642+00');
INSERT INTO public.events VALUES (1, '2026-11-21 10:22:49.749657+00', 'accepted', '2b086671db4d4a678d9b1a7691041f9f', NULL, '{"planned": 3, "new": 3}');
INSERT INTO public.events VALUES (2, '2026-11-21 10:22:49.775779+00', 'started', NULL, '00000000000000000000000000000000', '{"attempt": 1}');
INSERT INTO public.events VALUES (3, '2026-11-21 10:22:49.775779+00', 'started', NULL, '00000000000000000000000000000001', '{"attempt": 1}');
INSERT INTO public.events VALUES (4, '2026-11-21 10:22:49.775779+00', 'started', NULL, '00000000000000000000000000000002', '{"attempt": 1}');
INSERT INTO public.events VALUES (5, '2026-11-21 10:22:49.780516+00', 'succeeded', NULL, '00000000000000000000000000000000', '{"attempt": 1}');
INSERT INTO public.events VALUES (6, '2026-11-21 10:22:49.793692+00', 'failed', NULL, '00000000000000000000000000000001', '{"attempt": 1, "cause": "verdict", "reason": "density = 3e4 at particle 17"}');
INSERT INTO public.events VALUES (7, '2026-11-21 10:22:49.799868+00', 'failed', NULL, '00000000000000000000000000000002', '{"attempt": 1, "cause": "crash", "reason": "died"}');
INSERT INTO public.events VALUES (8, '2026-11-21 10:22:49.805627+00', 'started', '2b086671db4d4a678d9b1a7691041f9f', '444d73b8ee2e4bb08c2623282665f9ec', '{"attempt": 1}');
INSERT INTO public.events VALUES (9, '2026-11-21 10:22:49.809656+00', 'published', '2b086671db4d4a678d9b1a7691041f9f', '444d73b8ee2e4bb08c2623282665f9ec', '{"attempt": 1, "files": ["cube.nc", "report.html", "report.json"]}');
INSERT INTO public.events VALUES (10, '2026-11-21 10:22:49.817656+00', 'accepted', 'c069bfba13234ad8bd27ef4f207e15c6', NULL, '{"planned": 2, "new": 2}');
INSERT INTO public.events VALUES (11, '2026-11-21 10:22:49.82966+00', 'started', NULL, '0000000000000000000000000000000a', '{"attempt": 1}');
INSERT INTO public.events VALUES (12, '2026-11-21 10:22:49.833632+00', 'succeeded', NULL, '0000000000000000000000000000000a', '{"attempt": 1}');
INSERT INTO public.events VALUES (13, '2026-11-21 10:22:49.841635+00', 'cancelled', 'c069bfba13234ad8bd27ef4f207e15c6', NULL, '{"points": 1}');
INSERT INTO public.events VALUES (14, '2026-11-21 10:22:49.857736+00', 'started', 'c069bfba13234ad8bd27ef4f207e15c6', '90b9ae5d3655407e8e4de046609e033e', '{"attempt": 1}');
INSERT INTO public.events VALUES (15, '2026-11-21 10:22:49.861666+00', 'published', 'c069bfba13234ad8bd27ef4f207e15c6', '90b9ae5d3655407e8e4de046609e033e', '{"attempt": 1, "files": ["cube.nc", "report.html", "report.json"]}');
INSERT INTO public.events VALUES (16, '2026-11-21 10:22:49.869649+00', 'accepted', '29171cd04f0f4ff28d7c49841df4e370', NULL, '{"planned": 1, "new": 1}');
INSERT INTO public.events VALUES (17, '2026-11-21 10:22:49.885709+00', 'started', NULL, '00000000000000000000000000000014', '{"attempt": 1}');
INSERT INTO public.events VALUES (18, '2026-11-21 10:22:49.889675+00', 'succeeded', NULL, '00000000000000000000000000000014', '{"attempt": 1}');
INSERT INTO public.events VALUES (19, '2026-11-21 10:22:49.897658+00', 'started', '29171cd04f0f4ff28d7c49841df4e370', 'a2fd1c1c83a94b438a79a90aef3ac987', '{"attempt": 1}');
INSERT INTO public.events VALUES (20, '2026-11-21 10:22:49.901723+00', 'failed', '29171cd04f0f4ff28d7c49841df4e370', 'a2fd1c1c83a94b438a79a90aef3ac987', '{"attempt": 1, "cause": "error", "reason": "disk full"}');
INSERT INTO public.events VALUES (21, '2026-11-21 10:22:49.913639+00', 'accepted', '1a61977c6fb640f188d5b665daaa9c81', NULL, '{"planned": 4, "new": 3}');
INSERT INTO public.events VALUES (22, '2026-11-21 10:22:49.925638+00', 'started', NULL, '0000000000000000000000000000001e', '{"attempt": 1}');
INSERT INTO public.events VALUES (23, '2026-11-21 10:22:49.925638+00', 'started', NULL, '0000000000000000000000000000001f', '{"attempt": 1}');
INSERT INTO public.events VALUES (24, '2026-11-21 10:22:49.933657+00', 'requeued', NULL, '0000000000000000000000000000001f', '{"attempt": 1, "cause": "crash", "reason": "SIGSEGV"}');
INSERT INTO public.events VALUES (25, '2026-11-21 10:22:49.945664+00', 'accepted', 'e87e3da432284d9e9462c1dcf2be9d1c', NULL, '{"planned": 3, "new": 0}');
INSERT INTO public.events VALUES (26, '2026-11-21 10:22:50.925629+00', 'accepted', '09239e0237594bb2b50f1b637cc9ee79', NULL, '{"planned": 2, "new": 2}');
INSERT INTO public.jobs VALUES ('00000000000000000000000000000000', 'run', NULL, 'thin_plate', '{"id": "00000000000000000000000000000000", "scenario": "thin_plate", "parameters": {}}', 'succeeded', 0, 0, 1, 1, 1, '440abcf2', 0, 1, NULL, NULL, NULL, NULL, '{"measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 0.0001, "flags": []}}, "flags": [], "numbers": {"steps": 7.0}, "stop": "settled"}', 'runs/00/00000000000000000000000000000000/1-abcdef01/result.json', 2, '1111111111111111111111111111111111111111111111111111111111111111', 2, '2026-11-21 10:22:49.749657+00', '2026-11-21 10:22:49.749657+00', '2026-11-21 10:22:49.775779+00', '2026-11-21 10:22:49.780516+00');
INSERT INTO public.jobs VALUES ('00000000000000000000000000000001', 'run', NULL, 'thin_plate', '{"id": "00000000000000000000000000000001", "scenario": "thin_plate", "parameters": {}}', 'failed', 0, 1, 1, 1, 1, '440abcf2', 0, 1, NULL, 'verdict', 'UnphysicalState', 'density = 3e4 at particle 17', '{"measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 0.0001, "flags": []}}, "flags": [], "numbers": {"steps": 7.0}, "stop": "settled"}', 'runs/00/00000000000000000000000000000001/1-abcdef01/result.json', 2, '1111111111111111111111111111111111111111111111111111111111111111', 2, '2026-11-21 10:22:49.749657+00', '2026-11-21 10:22:49.749657+00', '2026-11-21 10:22:49.775779+00', '2026-11-21 10:22:49.793692+00');
INSERT INTO public.jobs VALUES ('00000000000000000000000000000002', 'run', NULL, 'thin_plate', '{"id": "00000000000000000000000000000002", "scenario": "thin_plate", "parameters": {}}', 'failed', 0, 2, 1, 1, 1, '440abcf2', 1, NULL, NULL, 'crash', 'SIGSEGV', 'died', NULL, NULL, NULL, NULL, NULL, '2026-11-21 10:22:49.749657+00', '2026-11-21 10:22:49.749657+00', '2026-11-21 10:22:49.775779+00', '2026-11-21 10:22:49.799868+00');
INSERT INTO public.jobs VALUES ('444d73b8ee2e4bb08c2623282665f9ec', 'publish', '2b086671db4d4a678d9b1a7691041f9f', NULL, NULL, 'succeeded', -10, 0, 1, 1, 1, 'bb554175', 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, 1, '2026-11-21 10:22:49.749657+00', '2026-11-21 10:22:49.799868+00', '2026-11-21 10:22:49.805627+00', '2026-11-21 10:22:49.809656+00');
INSERT INTO public.jobs VALUES ('0000000000000000000000000000000a', 'run', NULL, 'thin_plate', '{"id": "0000000000000000000000000000000a", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}', 'succeeded', 0, 0, 1, 1, 1, 'fe52fcd0', 0, 1, NULL, NULL, NULL, NULL, '{"measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 0.0001, "flags": []}}, "flags": [], "numbers": {"steps": 7.0}, "stop": "settled"}', 'runs/00/0000000000000000000000000000000a/1-abcdef01/result.json', 2, '1111111111111111111111111111111111111111111111111111111111111111', 2, '2026-11-21 10:22:49.817656+00', '2026-11-21 10:22:49.817656+00', '2026-11-21 10:22:49.82966+00', '2026-11-21 10:22:49.833632+00');
INSERT INTO public.jobs VALUES ('0000000000000000000000000000000b', 'run', NULL, 'thin_plate', '{"id": "0000000000000000000000000000000b", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}', 'cancelled', 0, 1, 1, 0, 0, NULL, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, '2026-11-21 10:22:49.817656+00', '2026-11-21 10:22:49.817656+00', NULL, '2026-11-21 10:22:49.841635+00');
INSERT INTO public.jobs VALUES ('90b9ae5d3655407e8e4de046609e033e', 'publish', 'c069bfba13234ad8bd27ef4f207e15c6', NULL, NULL, 'succeeded', -10, 0, 1, 1, 1, '983d75ea', 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, 1, '2026-11-21 10:22:49.817656+00', '2026-11-21 10:22:49.841635+00', '2026-11-21 10:22:49.857736+00', '2026-11-21 10:22:49.861666+00');
INSERT INTO public.jobs VALUES ('00000000000000000000000000000014', 'run', NULL, 'thin_plate', '{"id": "00000000000000000000000000000014", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}', 'succeeded', 0, 0, 1, 1, 1, 'e509c689', 0, 1, NULL, NULL, NULL, NULL, '{"measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 0.0001, "flags": []}}, "flags": [], "numbers": {"steps": 7.0}, "stop": "settled"}', 'runs/00/00000000000000000000000000000014/1-abcdef01/result.json', 2, '1111111111111111111111111111111111111111111111111111111111111111', 2, '2026-11-21 10:22:49.869649+00', '2026-11-21 10:22:49.869649+00', '2026-11-21 10:22:49.885709+00', '2026-11-21 10:22:49.889675+00');
INSERT INTO public.jobs VALUES ('a2fd1c1c83a94b438a79a90aef3ac987', 'publish', '29171cd04f0f4ff28d7c49841df4e370', NULL, NULL, 'failed', -10, 0, 1, 1, 1, '9bbedd8e', 0, NULL, NULL, 'error', 'OSError', 'disk full', NULL, NULL, NULL, NULL, NULL, '2026-11-21 10:22:49.869649+00', '2026-11-21 10:22:49.889675+00', '2026-11-21 10:22:49.897658+00', '2026-11-21 10:22:49.901723+00');
INSERT INTO public.jobs VALUES ('00000000000000000000000000000020', 'run', NULL, 'thin_plate', '{"id": "00000000000000000000000000000020", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}', 'queued', 0, 2, 1, 0, 0, NULL, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, '2026-11-21 10:22:49.913639+00', '2026-11-21 10:22:49.913639+00', NULL, NULL);
INSERT INTO public.jobs VALUES ('2782030af3d94343b861984354514e9c', 'publish', '1a61977c6fb640f188d5b665daaa9c81', NULL, NULL, 'waiting', -10, 0, 1, 0, 0, NULL, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, '2026-11-21 10:22:49.913639+00', '2026-11-21 10:22:49.913639+00', NULL, NULL);
INSERT INTO public.jobs VALUES ('0000000000000000000000000000001f', 'run', NULL, 'thin_plate', '{"id": "0000000000000000000000000000001f", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}', 'queued', 0, 1, 1, 1, 2, 'bd3cf89a', 1, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, '2026-11-21 10:22:49.913639+00', '2026-11-21 10:22:49.913639+00', '2026-11-21 10:22:49.925638+00', NULL);
INSERT INTO public.jobs VALUES ('0000000000000000000000000000001e', 'run', NULL, 'thin_plate', '{"id": "0000000000000000000000000000001e", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}', 'running', 0, 0, 1, 1, 2, 'bd3cf89a', 0, 0.5, '{"time": 1e-06, "step": 9, "fraction": 0.5}', NULL, NULL, NULL, NULL, NULL, NULL, NULL, 3, '2026-11-21 10:22:49.913639+00', '2026-11-21 10:22:49.913639+00', '2026-11-21 10:22:49.925638+00', NULL);
INSERT INTO public.jobs VALUES ('1963a534c55f4376b02f81692d9da0d3', 'publish', 'e87e3da432284d9e9462c1dcf2be9d1c', NULL, NULL, 'waiting', -10, 0, 1, 0, 0, NULL, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, '2026-11-21 10:22:49.945664+00', '2026-11-21 10:22:49.945664+00', NULL, NULL);
INSERT INTO public.jobs VALUES ('d5572392e808fe4c395407269628bc3d', 'run', NULL, 'thin_plate', '{"scenario": "thin_plate", "parameters": {"speed": 3000.0, "projectile_diameter": 0.008, "projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_shape": "sphere", "projectile_length": null, "geometry": "axisymmetric", "cells_per_diameter": 8.0, "edges": "fixed", "end_time": 6e-05, "stop": "settled", "settled_growth": 0.005, "settled_window": 5e-06, "eos_form": "hugoniot", "thermal_softening": true, "offset": 0.0, "failure": "none", "failure_strain": null, "failure_time": null, "recipe": "whipple", "shape": "gimp", "scheme": "musl", "particles_per_cell": 2, "viscosity_linear": 0.2, "viscosity_quadratic": 2.0, "courant": 0.3, "damping_rate": 0.0, "damping_order": 1, "tension": "recoverable", "contact": "none", "friction": 0.0, "fixed_dt": null, "plate_thickness": 0.002, "obliquity": 0.0, "plate_radius": 0.028}, "materials": {"projectile": {"name": "copper-ofhc", "title": "Copper, OFHC", "family": "copper", "density": 8930.0, "elastic": {"shear_modulus": 47700000000.0, "bulk_modulus": 138625748000.0}, "eos": {"kind": "mie-grueneisen", "c0": 3940.0, "s": 1.489, "gamma0": 2.02}, "thermal": {"heat_capacity": 383.0, "melt_temperature": 1356.0, "room_temperature": 294.0}, "strength": {"kind": "johnson-cook", "A": 90000000.0, "B": 292000000.0, "n": 0.31, "C": 0.025, "m": 1.09, "reference_rate": 1.0}, "tension": {"spall_strength": 1900000000.0}, "yield_stresses": [{"label": "Y = 240 MPa", "value": 240000000.0}, {"label": "Y = 157 MPa", "value": 157000000.0}, {"label": "Y = 120 MPa", "value": 120000000.0}, {"label": "Y = 90 MPa", "value": 90000000.0}], "brinell_hardness": null}, "target": {"name": "copper-ofhc", "title": "Copper, OFHC", "family": "copper", "density": 8930.0, "elastic": {"shear_modulus": 47700000000.0, "bulk_modulus": 138625748000.0}, "eos": {"kind": "mie-grueneisen", "c0": 3940.0, "s": 1.489, "gamma0": 2.02}, "thermal": {"heat_capacity": 383.0, "melt_temperature": 1356.0, "room_temperature": 294.0}, "strength": {"kind": "johnson-cook", "A": 90000000.0, "B": 292000000.0, "n": 0.31, "C": 0.025, "m": 1.09, "reference_rate": 1.0}, "tension": {"spall_strength": 1900000000.0}, "yield_stresses": [{"label": "Y = 240 MPa", "value": 240000000.0}, {"label": "Y = 157 MPa", "value": 157000000.0}, {"label": "Y = 120 MPa", "value": 120000000.0}, {"label": "Y = 90 MPa", "value": 90000000.0}], "brinell_hardness": null}}}', 'queued', 0, 0, 0.274625, 0, 0, NULL, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, '2026-11-21 10:22:50.925629+00', '2026-11-21 10:22:50.925629+00', NULL, NULL);
INSERT INTO public.jobs VALUES ('a8b02d213649ad24cb004efb5bf90e61', 'run', NULL, 'thin_plate', '{"scenario": "thin_plate", "parameters": {"speed": 6000.0, "projectile_diameter": 0.008, "projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_shape": "sphere", "projectile_length": null, "geometry": "axisymmetric", "cells_per_diameter": 8.0, "edges": "fixed", "end_time": 6e-05, "stop": "settled", "settled_growth": 0.005, "settled_window": 5e-06, "eos_form": "hugoniot", "thermal_softening": true, "offset": 0.0, "failure": "none", "failure_strain": null, "failure_time": null, "recipe": "whipple", "shape": "gimp", "scheme": "musl", "particles_per_cell": 2, "viscosity_linear": 0.2, "viscosity_quadratic": 2.0, "courant": 0.3, "damping_rate": 0.0, "damping_order": 1, "tension": "recoverable", "contact": "none", "friction": 0.0, "fixed_dt": null, "plate_thickness": 0.002, "obliquity": 0.0, "plate_radius": 0.028}, "materials": {"projectile": {"name": "copper-ofhc", "title": "Copper, OFHC", "family": "copper", "density": 8930.0, "elastic": {"shear_modulus": 47700000000.0, "bulk_modulus": 138625748000.0}, "eos": {"kind": "mie-grueneisen", "c0": 3940.0, "s": 1.489, "gamma0": 2.02}, "thermal": {"heat_capacity": 383.0, "melt_temperature": 1356.0, "room_temperature": 294.0}, "strength": {"kind": "johnson-cook", "A": 90000000.0, "B": 292000000.0, "n": 0.31, "C": 0.025, "m": 1.09, "reference_rate": 1.0}, "tension": {"spall_strength": 1900000000.0}, "yield_stresses": [{"label": "Y = 240 MPa", "value": 240000000.0}, {"label": "Y = 157 MPa", "value": 157000000.0}, {"label": "Y = 120 MPa", "value": 120000000.0}, {"label": "Y = 90 MPa", "value": 90000000.0}], "brinell_hardness": null}, "target": {"name": "copper-ofhc", "title": "Copper, OFHC", "family": "copper", "density": 8930.0, "elastic": {"shear_modulus": 47700000000.0, "bulk_modulus": 138625748000.0}, "eos": {"kind": "mie-grueneisen", "c0": 3940.0, "s": 1.489, "gamma0": 2.02}, "thermal": {"heat_capacity": 383.0, "melt_temperature": 1356.0, "room_temperature": 294.0}, "strength": {"kind": "johnson-cook", "A": 90000000.0, "B": 292000000.0, "n": 0.31, "C": 0.025, "m": 1.09, "reference_rate": 1.0}, "tension": {"spall_strength": 1900000000.0}, "yield_stresses": [{"label": "Y = 240 MPa", "value": 240000000.0}, {"label": "Y = 157 MPa", "value": 157000000.0}, {"label": "Y = 120 MPa", "value": 120000000.0}, {"label": "Y = 90 MPa", "value": 90000000.0}], "brinell_hardness": null}}}', 'queued', 0, 1, 0.338, 0, 0, NULL, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, '2026-11-21 10:22:50.925629+00', '2026-11-21 10:22:50.925629+00', NULL, NULL);
INSERT INTO public.jobs VALUES ('fa67eeeeea0b4d5184996bbf7c09d52c', 'publish', '09239e0237594bb2b50f1b637cc9ee79', NULL, NULL, 'waiting', -10, 0, 1, 0, 0, NULL, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL, '2026-11-21 10:22:50.925629+00', '2026-11-21 10:22:50.925629+00', NULL, NULL);
INSERT INTO public.points VALUES ('2b086671db4d4a678d9b1a7691041f9f', 0, '00000000000000000000000000000000', '[0]', '{"speed": 0.0}', false);
INSERT INTO public.points VALUES ('2b086671db4d4a678d9b1a7691041f9f', 1, '00000000000000000000000000000001', '[1]', '{"speed": 1000.0}', false);
INSERT INTO public.points VALUES ('2b086671db4d4a678d9b1a7691041f9f', 2, '00000000000000000000000000000002', '[2]', '{"speed": 2000.0}', false);
INSERT INTO public.points VALUES ('c069bfba13234ad8bd27ef4f207e15c6', 0, '0000000000000000000000000000000a', '[0]', '{"speed": 0.0}', false);
INSERT INTO public.points VALUES ('c069bfba13234ad8bd27ef4f207e15c6', 1, '0000000000000000000000000000000b', '[1]', '{"speed": 1000.0}', true);
INSERT INTO public.points VALUES ('29171cd04f0f4ff28d7c49841df4e370', 0, '00000000000000000000000000000014', '[0]', '{"speed": 0.0}', false);
INSERT INTO public.points VALUES ('1a61977c6fb640f188d5b665daaa9c81', 0, '0000000000000000000000000000001e', '[0]', '{"speed": 0.0}', false);
INSERT INTO public.points VALUES ('1a61977c6fb640f188d5b665daaa9c81', 1, '0000000000000000000000000000001f', '[1]', '{"speed": 1000.0}', false);
INSERT INTO public.points VALUES ('1a61977c6fb640f188d5b665daaa9c81', 2, '00000000000000000000000000000020', '[2]', '{"speed": 2000.0}', false);
INSERT INTO public.points VALUES ('1a61977c6fb640f188d5b665daaa9c81', 3, '00000000000000000000000000000000', '[3]', '{"speed": 3000.0}', false);
INSERT INTO public.points VALUES ('e87e3da432284d9e9462c1dcf2be9d1c', 0, '0000000000000000000000000000001e', '[0]', '{"speed": 0.0}', false);
INSERT INTO public.points VALUES ('e87e3da432284d9e9462c1dcf2be9d1c', 1, '0000000000000000000000000000001f', '[1]', '{"speed": 1000.0}', false);
INSERT INTO public.points VALUES ('e87e3da432284d9e9462c1dcf2be9d1c', 2, '00000000000000000000000000000020', '[2]', '{"speed": 2000.0}', false);
INSERT INTO public.points VALUES ('09239e0237594bb2b50f1b637cc9ee79', 0, 'd5572392e808fe4c395407269628bc3d', '[0]', '{"speed": 3000.0}', false);
INSERT INTO public.points VALUES ('09239e0237594bb2b50f1b637cc9ee79', 1, 'a8b02d213649ad24cb004efb5bf90e61', '[1]', '{"speed": 6000.0}', false);
INSERT INTO public.sweeps VALUES (1, '2b086671db4d4a678d9b1a7691041f9f', 'done', 'done', 'thin_plate', '{"name": "done", "runs": ["00000000000000000000000000000000", "00000000000000000000000000000001", "00000000000000000000000000000002"]}', '5e60cfa889cd4f1965cf09915e8a5c02cd8e82ed84c08a34ddedaae7e2dff2cb', 3, 3, '2026-11-21 10:22:49.749657+00', NULL);
INSERT INTO public.sweeps VALUES (2, 'c069bfba13234ad8bd27ef4f207e15c6', 'cancelled', 'cancelled', 'thin_plate', '{"name": "cancelled", "runs": ["0000000000000000000000000000000a", "0000000000000000000000000000000b"]}', '6b9c6038c259b6de7ffd3b2f7ba5dde15f1bf3d88cc6351ce07a25693a8d3681', 2, 2, '2026-11-21 10:22:49.817656+00', '2026-11-21 10:22:49.841635+00');
INSERT INTO public.sweeps VALUES (3, '29171cd04f0f4ff28d7c49841df4e370', 'unpublishable', 'unpublishable', 'thin_plate', '{"name": "unpublishable", "runs": ["00000000000000000000000000000014"]}', '840b457df0a28fa1512f5a0cc41626425a0d5d3288e2ba6a086c1da384884004', 1, 1, '2026-11-21 10:22:49.869649+00', NULL);
INSERT INTO public.sweeps VALUES (4, '1a61977c6fb640f188d5b665daaa9c81', 'under way', 'under way', 'thin_plate', '{"name": "under way", "runs": ["0000000000000000000000000000001e", "0000000000000000000000000000001f", "00000000000000000000000000000020", "00000000000000000000000000000000"]}', 'a8fc57d3f883e63e1b036677a23c1e1d17e0413bede42835eaca54f2e80a21c3', 4, 3, '2026-11-21 10:22:49.913639+00', NULL);
INSERT INTO public.sweeps VALUES (5, 'e87e3da432284d9e9462c1dcf2be9d1c', 'joined', 'joined', 'thin_plate', '{"name": "joined", "runs": ["0000000000000000000000000000001e", "0000000000000000000000000000001f", "00000000000000000000000000000020"]}', 'bd6bf5a2fbc3a179db7b5a7b801fa4771e93a75eb15f167e91953d3128ec52fa', 3, 0, '2026-11-21 10:22:49.945664+00', NULL);
INSERT INTO public.sweeps VALUES (6, '09239e0237594bb2b50f1b637cc9ee79', 'two-speeds', 'two-speeds', 'thin_plate', '{"name": "two-speeds", "title": "two-speeds", "scenario": "thin_plate", "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm", "plate_thickness": "2 mm"}, "axes": {"speed": ["3 km/s", "6 km/s"]}, "combine": "grid", "resolution": 8.0}', '612b8d1d0a4dac9ca58937eca1076d7b55559039ef399f4b0f3949830bd55a69', 2, 2, '2026-11-21 10:22:50.925629+00', NULL);
SELECT pg_catalog.setval('public.dispatchers_epoch_seq', 2, true);
SELECT pg_catalog.setval('public.events_number_seq', 26, true);
SELECT pg_catalog.setval('public.sweeps_number_seq', 6, true);
ALTER TABLE ONLY public.alembic_version
    ADD CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num);
ALTER TABLE ONLY public.artifacts
    ADD CONSTRAINT artifacts_pkey PRIMARY KEY (sweep_id, name);
ALTER TABLE ONLY public.dispatchers
    ADD CONSTRAINT dispatchers_pkey PRIMARY KEY (epoch);
ALTER TABLE ONLY public.events
    ADD CONSTRAINT events_pkey PRIMARY KEY (number);
ALTER TABLE ONLY public.jobs
    ADD CONSTRAINT jobs_pkey PRIMARY KEY (id);
ALTER TABLE ONLY public.jobs
    ADD CONSTRAINT jobs_sweep_id_key UNIQUE (sweep_id);
ALTER TABLE ONLY public.points
    ADD CONSTRAINT points_pkey PRIMARY KEY (sweep_id, ordinal);
ALTER TABLE ONLY public.sweeps
    ADD CONSTRAINT sweeps_id_key UNIQUE (id);
ALTER TABLE ONLY public.sweeps
    ADD CONSTRAINT sweeps_pkey PRIMARY KEY (number);
CREATE INDEX events_job ON public.events USING btree (job_id, number);
CREATE INDEX events_sweep ON public.events USING btree (sweep_id, number);
CREATE INDEX jobs_queue ON public.jobs USING btree (state, priority, queued, ordinal);
CREATE INDEX points_run ON public.points USING btree (run_id, sweep_id);
CREATE INDEX sweeps_digest ON public.sweeps USING btree (digest);
ALTER TABLE ONLY public.artifacts
    ADD CONSTRAINT artifacts_sweep_id_fkey FOREIGN KEY (sweep_id) REFERENCES public.sweeps(id);
ALTER TABLE ONLY public.jobs
    ADD CONSTRAINT jobs_sweep_id_fkey FOREIGN KEY (sweep_id) REFERENCES public.sweeps(id);
ALTER TABLE ONLY public.points
    ADD CONSTRAINT points_run_id_fkey FOREIGN KEY (run_id) REFERENCES public.jobs(id);
ALTER TABLE ONLY public.points
    ADD CONSTRAINT points_sweep_id_fkey FOREIGN KEY (sweep_id) REFERENCES public.sweeps(id);
