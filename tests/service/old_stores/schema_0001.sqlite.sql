-- A store of the first schema with one of everything, as Connection.iterdump writes it; made once, never again.
BEGIN TRANSACTION;
CREATE TABLE alembic_version (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO "alembic_version" VALUES('0001');
CREATE TABLE artifacts (
	sweep_id VARCHAR(32) NOT NULL, 
	name VARCHAR(64) NOT NULL, 
	path TEXT NOT NULL, 
	size BIGINT NOT NULL, 
	sha256 VARCHAR(64) NOT NULL, 
	PRIMARY KEY (sweep_id, name), 
	FOREIGN KEY(sweep_id) REFERENCES sweeps (id)
);
INSERT INTO "artifacts" VALUES('1a3fcdd6f39b4a398e326c175388ea40','cube.nc','sweeps/1a3fcdd6f39b4a398e326c175388ea40/1-abcdef01/cube.nc',3,'2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO "artifacts" VALUES('1a3fcdd6f39b4a398e326c175388ea40','report.html','sweeps/1a3fcdd6f39b4a398e326c175388ea40/1-abcdef01/report.html',3,'2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO "artifacts" VALUES('1a3fcdd6f39b4a398e326c175388ea40','report.json','sweeps/1a3fcdd6f39b4a398e326c175388ea40/1-abcdef01/report.json',3,'2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO "artifacts" VALUES('d3e915249cd4456b9cd8a75d2a29168e','cube.nc','sweeps/d3e915249cd4456b9cd8a75d2a29168e/1-abcdef01/cube.nc',3,'2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO "artifacts" VALUES('d3e915249cd4456b9cd8a75d2a29168e','report.html','sweeps/d3e915249cd4456b9cd8a75d2a29168e/1-abcdef01/report.html',3,'2222222222222222222222222222222222222222222222222222222222222222');
INSERT INTO "artifacts" VALUES('d3e915249cd4456b9cd8a75d2a29168e','report.json','sweeps/d3e915249cd4456b9cd8a75d2a29168e/1-abcdef01/report.json',3,'2222222222222222222222222222222222222222222222222222222222222222');
CREATE TABLE dispatchers (
	epoch INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	owner TEXT NOT NULL, 
	started DATETIME NOT NULL
);
INSERT INTO "dispatchers" VALUES(1,'old:1','2026-11-21 10:22:42.422446');
INSERT INTO "dispatchers" VALUES(2,'old:2','2026-11-21 10:22:42.593747');
CREATE TABLE events (
	number INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	time DATETIME NOT NULL, 
	kind VARCHAR(16) NOT NULL, 
	sweep_id VARCHAR(32), 
	job_id VARCHAR(32), 
	body JSON NOT NULL
);
INSERT INTO "events" VALUES(1,'2026-11-21 10:22:42.429687','accepted','1a3fcdd6f39b4a398e326c175388ea40',NULL,'{"planned": 3, "new": 3}');
INSERT INTO "events" VALUES(2,'2026-11-21 10:22:42.453703','started',NULL,'00000000000000000000000000000000','{"attempt": 1}');
INSERT INTO "events" VALUES(3,'2026-11-21 10:22:42.453703','started',NULL,'00000000000000000000000000000001','{"attempt": 1}');
INSERT INTO "events" VALUES(4,'2026-11-21 10:22:42.453703','started',NULL,'00000000000000000000000000000002','{"attempt": 1}');
INSERT INTO "events" VALUES(5,'2026-11-21 10:22:42.461692','succeeded',NULL,'00000000000000000000000000000000','{"attempt": 1}');
INSERT INTO "events" VALUES(6,'2026-11-21 10:22:42.469637','failed',NULL,'00000000000000000000000000000001','{"attempt": 1, "cause": "verdict", "reason": "density = 3e4 at particle 17"}');
INSERT INTO "events" VALUES(7,'2026-11-21 10:22:42.477911','failed',NULL,'00000000000000000000000000000002','{"attempt": 1, "cause": "crash", "reason": "died"}');
INSERT INTO "events" VALUES(8,'2026-11-21 10:22:42.485436','started','1a3fcdd6f39b4a398e326c175388ea40','39d51c3c9b2f47dfb1515e7dc59db9f0','{"attempt": 1}');
INSERT INTO "events" VALUES(9,'2026-11-21 10:22:42.489645','published','1a3fcdd6f39b4a398e326c175388ea40','39d51c3c9b2f47dfb1515e7dc59db9f0','{"attempt": 1, "files": ["cube.nc", "report.html", "report.json"]}');
INSERT INTO "events" VALUES(10,'2026-11-21 10:22:42.497724','accepted','d3e915249cd4456b9cd8a75d2a29168e',NULL,'{"planned": 2, "new": 2}');
INSERT INTO "events" VALUES(11,'2026-11-21 10:22:42.505657','started',NULL,'0000000000000000000000000000000a','{"attempt": 1}');
INSERT INTO "events" VALUES(12,'2026-11-21 10:22:42.509688','succeeded',NULL,'0000000000000000000000000000000a','{"attempt": 1}');
INSERT INTO "events" VALUES(13,'2026-11-21 10:22:42.517711','cancelled','d3e915249cd4456b9cd8a75d2a29168e',NULL,'{"points": 1}');
INSERT INTO "events" VALUES(14,'2026-11-21 10:22:42.529643','started','d3e915249cd4456b9cd8a75d2a29168e','f841c70b8776401bb48ce584c2ad7966','{"attempt": 1}');
INSERT INTO "events" VALUES(15,'2026-11-21 10:22:42.533607','published','d3e915249cd4456b9cd8a75d2a29168e','f841c70b8776401bb48ce584c2ad7966','{"attempt": 1, "files": ["cube.nc", "report.html", "report.json"]}');
INSERT INTO "events" VALUES(16,'2026-11-21 10:22:42.535394','accepted','6741ba44245c4352a3313dd5ee6ffa7d',NULL,'{"planned": 1, "new": 1}');
INSERT INTO "events" VALUES(17,'2026-11-21 10:22:42.553725','started',NULL,'00000000000000000000000000000014','{"attempt": 1}');
INSERT INTO "events" VALUES(18,'2026-11-21 10:22:42.561810','succeeded',NULL,'00000000000000000000000000000014','{"attempt": 1}');
INSERT INTO "events" VALUES(19,'2026-11-21 10:22:42.573693','started','6741ba44245c4352a3313dd5ee6ffa7d','b7757c7780ad4e7a87b04bb258bfc76d','{"attempt": 1}');
INSERT INTO "events" VALUES(20,'2026-11-21 10:22:42.581876','failed','6741ba44245c4352a3313dd5ee6ffa7d','b7757c7780ad4e7a87b04bb258bfc76d','{"attempt": 1, "cause": "error", "reason": "disk full"}');
INSERT INTO "events" VALUES(21,'2026-11-21 10:22:42.597686','accepted','3fac108271484129809d3974ae5a4cd5',NULL,'{"planned": 4, "new": 3}');
INSERT INTO "events" VALUES(22,'2026-11-21 10:22:42.609732','started',NULL,'0000000000000000000000000000001e','{"attempt": 1}');
INSERT INTO "events" VALUES(23,'2026-11-21 10:22:42.609732','started',NULL,'0000000000000000000000000000001f','{"attempt": 1}');
INSERT INTO "events" VALUES(24,'2026-11-21 10:22:42.617723','requeued',NULL,'0000000000000000000000000000001f','{"attempt": 1, "cause": "crash", "reason": "SIGSEGV"}');
INSERT INTO "events" VALUES(25,'2026-11-21 10:22:42.635672','accepted','d7d30ba838794583bd5194f1ff82436c',NULL,'{"planned": 3, "new": 0}');
INSERT INTO "events" VALUES(26,'2026-11-21 10:22:43.733281','accepted','34e7d5d0dce14215862639a471310a0c',NULL,'{"planned": 2, "new": 2}');
CREATE TABLE jobs (
	id VARCHAR(32) NOT NULL, 
	kind VARCHAR(16) NOT NULL, 
	sweep_id VARCHAR(32), 
	scenario TEXT, 
	spec JSON, 
	state VARCHAR(16) NOT NULL, 
	priority INTEGER NOT NULL, 
	ordinal INTEGER NOT NULL, 
	cost FLOAT NOT NULL, 
	attempt INTEGER NOT NULL, 
	epoch INTEGER NOT NULL, 
	token VARCHAR(16), 
	crashes INTEGER NOT NULL, 
	fraction FLOAT, 
	progress JSON, 
	cause VARCHAR(16), 
	failure TEXT, 
	reason TEXT, 
	summary JSON, 
	path TEXT, 
	size BIGINT, 
	sha256 VARCHAR(64), 
	seconds FLOAT, 
	created DATETIME NOT NULL, 
	queued DATETIME NOT NULL, 
	started DATETIME, 
	finished DATETIME, 
	PRIMARY KEY (id), 
	UNIQUE (sweep_id), 
	FOREIGN KEY(sweep_id) REFERENCES sweeps (id)
);
INSERT INTO "jobs" VALUES('00000000000000000000000000000000','run',NULL,'thin_plate','{"id": "00000000000000000000000000000000", "scenario": "thin_plate", "parameters": {}}','succeeded',0,0,1.0,1,1,'3077e44e',0,1.0,NULL,NULL,NULL,NULL,'{"measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 0.0001, "flags": []}}, "flags": [], "numbers": {"steps": 7.0}, "stop": "settled"}','runs/00/00000000000000000000000000000000/1-abcdef01/result.json',2,'1111111111111111111111111111111111111111111111111111111111111111',2.0,'2026-11-21 10:22:42.429687','2026-11-21 10:22:42.429687','2026-11-21 10:22:42.453703','2026-11-21 10:22:42.461692');
INSERT INTO "jobs" VALUES('00000000000000000000000000000001','run',NULL,'thin_plate','{"id": "00000000000000000000000000000001", "scenario": "thin_plate", "parameters": {}}','failed',0,1,1.0,1,1,'3077e44e',0,1.0,NULL,'verdict','UnphysicalState','density = 3e4 at particle 17','{"measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 0.0001, "flags": []}}, "flags": [], "numbers": {"steps": 7.0}, "stop": "settled"}','runs/00/00000000000000000000000000000001/1-abcdef01/result.json',2,'1111111111111111111111111111111111111111111111111111111111111111',2.0,'2026-11-21 10:22:42.429687','2026-11-21 10:22:42.429687','2026-11-21 10:22:42.453703','2026-11-21 10:22:42.469637');
INSERT INTO "jobs" VALUES('00000000000000000000000000000002','run',NULL,'thin_plate','{"id": "00000000000000000000000000000002", "scenario": "thin_plate", "parameters": {}}','failed',0,2,1.0,1,1,'3077e44e',1,NULL,NULL,'crash','SIGSEGV','died',NULL,NULL,NULL,NULL,NULL,'2026-11-21 10:22:42.429687','2026-11-21 10:22:42.429687','2026-11-21 10:22:42.453703','2026-11-21 10:22:42.477911');
INSERT INTO "jobs" VALUES('39d51c3c9b2f47dfb1515e7dc59db9f0','publish','1a3fcdd6f39b4a398e326c175388ea40',NULL,NULL,'succeeded',-10,0,1.0,1,1,'e4d3767d',0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,1.0,'2026-11-21 10:22:42.429687','2026-11-21 10:22:42.477911','2026-11-21 10:22:42.485436','2026-11-21 10:22:42.489645');
INSERT INTO "jobs" VALUES('0000000000000000000000000000000a','run',NULL,'thin_plate','{"id": "0000000000000000000000000000000a", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}','succeeded',0,0,1.0,1,1,'7f5fb559',0,1.0,NULL,NULL,NULL,NULL,'{"measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 0.0001, "flags": []}}, "flags": [], "numbers": {"steps": 7.0}, "stop": "settled"}','runs/00/0000000000000000000000000000000a/1-abcdef01/result.json',2,'1111111111111111111111111111111111111111111111111111111111111111',2.0,'2026-11-21 10:22:42.497724','2026-11-21 10:22:42.497724','2026-11-21 10:22:42.505657','2026-11-21 10:22:42.509688');
INSERT INTO "jobs" VALUES('0000000000000000000000000000000b','run',NULL,'thin_plate','{"id": "0000000000000000000000000000000b", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}','cancelled',0,1,1.0,0,0,NULL,0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,'2026-11-21 10:22:42.497724','2026-11-21 10:22:42.497724',NULL,'2026-11-21 10:22:42.517711');
INSERT INTO "jobs" VALUES('f841c70b8776401bb48ce584c2ad7966','publish','d3e915249cd4456b9cd8a75d2a29168e',NULL,NULL,'succeeded',-10,0,1.0,1,1,'10920b87',0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,1.0,'2026-11-21 10:22:42.497724','2026-11-21 10:22:42.517711','2026-11-21 10:22:42.529643','2026-11-21 10:22:42.533607');
INSERT INTO "jobs" VALUES('00000000000000000000000000000014','run',NULL,'thin_plate','{"id": "00000000000000000000000000000014", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}','succeeded',0,0,1.0,1,1,'ef51080a',0,1.0,NULL,NULL,NULL,NULL,'{"measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 0.0001, "flags": []}}, "flags": [], "numbers": {"steps": 7.0}, "stop": "settled"}','runs/00/00000000000000000000000000000014/1-abcdef01/result.json',2,'1111111111111111111111111111111111111111111111111111111111111111',2.0,'2026-11-21 10:22:42.535394','2026-11-21 10:22:42.535394','2026-11-21 10:22:42.553725','2026-11-21 10:22:42.561810');
INSERT INTO "jobs" VALUES('b7757c7780ad4e7a87b04bb258bfc76d','publish','6741ba44245c4352a3313dd5ee6ffa7d',NULL,NULL,'failed',-10,0,1.0,1,1,'ea53fa32',0,NULL,NULL,'error','OSError','disk full',NULL,NULL,NULL,NULL,NULL,'2026-11-21 10:22:42.535394','2026-11-21 10:22:42.561810','2026-11-21 10:22:42.573693','2026-11-21 10:22:42.581876');
INSERT INTO "jobs" VALUES('0000000000000000000000000000001e','run',NULL,'thin_plate','{"id": "0000000000000000000000000000001e", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}','running',0,0,1.0,1,2,'7a722a1a',0,0.5,'{"time": 1e-06, "step": 9, "fraction": 0.5}',NULL,NULL,NULL,NULL,NULL,NULL,NULL,3.0,'2026-11-21 10:22:42.597686','2026-11-21 10:22:42.597686','2026-11-21 10:22:42.609732',NULL);
INSERT INTO "jobs" VALUES('0000000000000000000000000000001f','run',NULL,'thin_plate','{"id": "0000000000000000000000000000001f", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}','queued',0,1,1.0,1,2,'7a722a1a',1,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,'2026-11-21 10:22:42.597686','2026-11-21 10:22:42.597686','2026-11-21 10:22:42.609732',NULL);
INSERT INTO "jobs" VALUES('00000000000000000000000000000020','run',NULL,'thin_plate','{"id": "00000000000000000000000000000020", "scenario": "thin_plate", "parameters": {"behaviour": "fine"}}','queued',0,2,1.0,0,0,NULL,0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,'2026-11-21 10:22:42.597686','2026-11-21 10:22:42.597686',NULL,NULL);
INSERT INTO "jobs" VALUES('5bca74d01cf04f208f4ce41ea94b3e78','publish','3fac108271484129809d3974ae5a4cd5',NULL,NULL,'waiting',-10,0,1.0,0,0,NULL,0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,'2026-11-21 10:22:42.597686','2026-11-21 10:22:42.597686',NULL,NULL);
INSERT INTO "jobs" VALUES('2bb806b05be94af4ab9857d74bd13231','publish','d7d30ba838794583bd5194f1ff82436c',NULL,NULL,'waiting',-10,0,1.0,0,0,NULL,0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,'2026-11-21 10:22:42.635672','2026-11-21 10:22:42.635672',NULL,NULL);
INSERT INTO "jobs" VALUES('d5572392e808fe4c395407269628bc3d','run',NULL,'thin_plate','{"scenario": "thin_plate", "parameters": {"speed": 3000.0, "projectile_diameter": 0.008, "projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_shape": "sphere", "projectile_length": null, "geometry": "axisymmetric", "cells_per_diameter": 8.0, "edges": "fixed", "end_time": 6e-05, "stop": "settled", "settled_growth": 0.005, "settled_window": 5e-06, "eos_form": "hugoniot", "thermal_softening": true, "offset": 0.0, "failure": "none", "failure_strain": null, "failure_time": null, "recipe": "whipple", "shape": "gimp", "scheme": "musl", "particles_per_cell": 2, "viscosity_linear": 0.2, "viscosity_quadratic": 2.0, "courant": 0.3, "damping_rate": 0.0, "damping_order": 1, "tension": "recoverable", "contact": "none", "friction": 0.0, "fixed_dt": null, "plate_thickness": 0.002, "obliquity": 0.0, "plate_radius": 0.028}, "materials": {"projectile": {"name": "copper-ofhc", "title": "Copper, OFHC", "family": "copper", "density": 8930.0, "elastic": {"shear_modulus": 47700000000.0, "bulk_modulus": 138625748000.0}, "eos": {"kind": "mie-grueneisen", "c0": 3940.0, "s": 1.489, "gamma0": 2.02}, "thermal": {"heat_capacity": 383.0, "melt_temperature": 1356.0, "room_temperature": 294.0}, "strength": {"kind": "johnson-cook", "A": 90000000.0, "B": 292000000.0, "n": 0.31, "C": 0.025, "m": 1.09, "reference_rate": 1.0}, "tension": {"spall_strength": 1900000000.0}, "yield_stresses": [{"label": "Y = 240 MPa", "value": 240000000.0}, {"label": "Y = 157 MPa", "value": 157000000.0}, {"label": "Y = 120 MPa", "value": 120000000.0}, {"label": "Y = 90 MPa", "value": 90000000.0}], "brinell_hardness": null}, "target": {"name": "copper-ofhc", "title": "Copper, OFHC", "family": "copper", "density": 8930.0, "elastic": {"shear_modulus": 47700000000.0, "bulk_modulus": 138625748000.0}, "eos": {"kind": "mie-grueneisen", "c0": 3940.0, "s": 1.489, "gamma0": 2.02}, "thermal": {"heat_capacity": 383.0, "melt_temperature": 1356.0, "room_temperature": 294.0}, "strength": {"kind": "johnson-cook", "A": 90000000.0, "B": 292000000.0, "n": 0.31, "C": 0.025, "m": 1.09, "reference_rate": 1.0}, "tension": {"spall_strength": 1900000000.0}, "yield_stresses": [{"label": "Y = 240 MPa", "value": 240000000.0}, {"label": "Y = 157 MPa", "value": 157000000.0}, {"label": "Y = 120 MPa", "value": 120000000.0}, {"label": "Y = 90 MPa", "value": 90000000.0}], "brinell_hardness": null}}}','queued',0,0,0.274625,0,0,NULL,0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,'2026-11-21 10:22:43.733281','2026-11-21 10:22:43.733281',NULL,NULL);
INSERT INTO "jobs" VALUES('a8b02d213649ad24cb004efb5bf90e61','run',NULL,'thin_plate','{"scenario": "thin_plate", "parameters": {"speed": 6000.0, "projectile_diameter": 0.008, "projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_shape": "sphere", "projectile_length": null, "geometry": "axisymmetric", "cells_per_diameter": 8.0, "edges": "fixed", "end_time": 6e-05, "stop": "settled", "settled_growth": 0.005, "settled_window": 5e-06, "eos_form": "hugoniot", "thermal_softening": true, "offset": 0.0, "failure": "none", "failure_strain": null, "failure_time": null, "recipe": "whipple", "shape": "gimp", "scheme": "musl", "particles_per_cell": 2, "viscosity_linear": 0.2, "viscosity_quadratic": 2.0, "courant": 0.3, "damping_rate": 0.0, "damping_order": 1, "tension": "recoverable", "contact": "none", "friction": 0.0, "fixed_dt": null, "plate_thickness": 0.002, "obliquity": 0.0, "plate_radius": 0.028}, "materials": {"projectile": {"name": "copper-ofhc", "title": "Copper, OFHC", "family": "copper", "density": 8930.0, "elastic": {"shear_modulus": 47700000000.0, "bulk_modulus": 138625748000.0}, "eos": {"kind": "mie-grueneisen", "c0": 3940.0, "s": 1.489, "gamma0": 2.02}, "thermal": {"heat_capacity": 383.0, "melt_temperature": 1356.0, "room_temperature": 294.0}, "strength": {"kind": "johnson-cook", "A": 90000000.0, "B": 292000000.0, "n": 0.31, "C": 0.025, "m": 1.09, "reference_rate": 1.0}, "tension": {"spall_strength": 1900000000.0}, "yield_stresses": [{"label": "Y = 240 MPa", "value": 240000000.0}, {"label": "Y = 157 MPa", "value": 157000000.0}, {"label": "Y = 120 MPa", "value": 120000000.0}, {"label": "Y = 90 MPa", "value": 90000000.0}], "brinell_hardness": null}, "target": {"name": "copper-ofhc", "title": "Copper, OFHC", "family": "copper", "density": 8930.0, "elastic": {"shear_modulus": 47700000000.0, "bulk_modulus": 138625748000.0}, "eos": {"kind": "mie-grueneisen", "c0": 3940.0, "s": 1.489, "gamma0": 2.02}, "thermal": {"heat_capacity": 383.0, "melt_temperature": 1356.0, "room_temperature": 294.0}, "strength": {"kind": "johnson-cook", "A": 90000000.0, "B": 292000000.0, "n": 0.31, "C": 0.025, "m": 1.09, "reference_rate": 1.0}, "tension": {"spall_strength": 1900000000.0}, "yield_stresses": [{"label": "Y = 240 MPa", "value": 240000000.0}, {"label": "Y = 157 MPa", "value": 157000000.0}, {"label": "Y = 120 MPa", "value": 120000000.0}, {"label": "Y = 90 MPa", "value": 90000000.0}], "brinell_hardness": null}}}','queued',0,1,0.338,0,0,NULL,0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,'2026-11-21 10:22:43.733281','2026-11-21 10:22:43.733281',NULL,NULL);
INSERT INTO "jobs" VALUES('f351bffb5036457d853d44e6f2161a8c','publish','34e7d5d0dce14215862639a471310a0c',NULL,NULL,'waiting',-10,0,1.0,0,0,NULL,0,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,NULL,'2026-11-21 10:22:43.733281','2026-11-21 10:22:43.733281',NULL,NULL);
CREATE TABLE points (
	sweep_id VARCHAR(32) NOT NULL, 
	ordinal INTEGER NOT NULL, 
	run_id VARCHAR(32) NOT NULL, 
	place JSON NOT NULL, 
	coordinates JSON NOT NULL, 
	detached BOOLEAN NOT NULL, 
	PRIMARY KEY (sweep_id, ordinal), 
	FOREIGN KEY(sweep_id) REFERENCES sweeps (id), 
	FOREIGN KEY(run_id) REFERENCES jobs (id)
);
INSERT INTO "points" VALUES('1a3fcdd6f39b4a398e326c175388ea40',0,'00000000000000000000000000000000','[0]','{"speed": 0.0}',0);
INSERT INTO "points" VALUES('1a3fcdd6f39b4a398e326c175388ea40',1,'00000000000000000000000000000001','[1]','{"speed": 1000.0}',0);
INSERT INTO "points" VALUES('1a3fcdd6f39b4a398e326c175388ea40',2,'00000000000000000000000000000002','[2]','{"speed": 2000.0}',0);
INSERT INTO "points" VALUES('d3e915249cd4456b9cd8a75d2a29168e',0,'0000000000000000000000000000000a','[0]','{"speed": 0.0}',0);
INSERT INTO "points" VALUES('d3e915249cd4456b9cd8a75d2a29168e',1,'0000000000000000000000000000000b','[1]','{"speed": 1000.0}',1);
INSERT INTO "points" VALUES('6741ba44245c4352a3313dd5ee6ffa7d',0,'00000000000000000000000000000014','[0]','{"speed": 0.0}',0);
INSERT INTO "points" VALUES('3fac108271484129809d3974ae5a4cd5',0,'0000000000000000000000000000001e','[0]','{"speed": 0.0}',0);
INSERT INTO "points" VALUES('3fac108271484129809d3974ae5a4cd5',1,'0000000000000000000000000000001f','[1]','{"speed": 1000.0}',0);
INSERT INTO "points" VALUES('3fac108271484129809d3974ae5a4cd5',2,'00000000000000000000000000000020','[2]','{"speed": 2000.0}',0);
INSERT INTO "points" VALUES('3fac108271484129809d3974ae5a4cd5',3,'00000000000000000000000000000000','[3]','{"speed": 3000.0}',0);
INSERT INTO "points" VALUES('d7d30ba838794583bd5194f1ff82436c',0,'0000000000000000000000000000001e','[0]','{"speed": 0.0}',0);
INSERT INTO "points" VALUES('d7d30ba838794583bd5194f1ff82436c',1,'0000000000000000000000000000001f','[1]','{"speed": 1000.0}',0);
INSERT INTO "points" VALUES('d7d30ba838794583bd5194f1ff82436c',2,'00000000000000000000000000000020','[2]','{"speed": 2000.0}',0);
INSERT INTO "points" VALUES('34e7d5d0dce14215862639a471310a0c',0,'d5572392e808fe4c395407269628bc3d','[0]','{"speed": 3000.0}',0);
INSERT INTO "points" VALUES('34e7d5d0dce14215862639a471310a0c',1,'a8b02d213649ad24cb004efb5bf90e61','[1]','{"speed": 6000.0}',0);
CREATE TABLE sweeps (
	number INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	id VARCHAR(32) NOT NULL, 
	name TEXT NOT NULL, 
	title TEXT NOT NULL, 
	scenario TEXT NOT NULL, 
	document JSON NOT NULL, 
	digest VARCHAR(64) NOT NULL, 
	planned INTEGER NOT NULL, 
	new INTEGER NOT NULL, 
	created DATETIME NOT NULL, 
	cancelled DATETIME, 
	UNIQUE (id)
);
INSERT INTO "sweeps" VALUES(1,'1a3fcdd6f39b4a398e326c175388ea40','done','done','thin_plate','{"name": "done", "runs": ["00000000000000000000000000000000", "00000000000000000000000000000001", "00000000000000000000000000000002"]}','5e60cfa889cd4f1965cf09915e8a5c02cd8e82ed84c08a34ddedaae7e2dff2cb',3,3,'2026-11-21 10:22:42.429687',NULL);
INSERT INTO "sweeps" VALUES(2,'d3e915249cd4456b9cd8a75d2a29168e','cancelled','cancelled','thin_plate','{"name": "cancelled", "runs": ["0000000000000000000000000000000a", "0000000000000000000000000000000b"]}','6b9c6038c259b6de7ffd3b2f7ba5dde15f1bf3d88cc6351ce07a25693a8d3681',2,2,'2026-11-21 10:22:42.497724','2026-11-21 10:22:42.517711');
INSERT INTO "sweeps" VALUES(3,'6741ba44245c4352a3313dd5ee6ffa7d','unpublishable','unpublishable','thin_plate','{"name": "unpublishable", "runs": ["00000000000000000000000000000014"]}','840b457df0a28fa1512f5a0cc41626425a0d5d3288e2ba6a086c1da384884004',1,1,'2026-11-21 10:22:42.535394',NULL);
INSERT INTO "sweeps" VALUES(4,'3fac108271484129809d3974ae5a4cd5','under way','under way','thin_plate','{"name": "under way", "runs": ["0000000000000000000000000000001e", "0000000000000000000000000000001f", "00000000000000000000000000000020", "00000000000000000000000000000000"]}','a8fc57d3f883e63e1b036677a23c1e1d17e0413bede42835eaca54f2e80a21c3',4,3,'2026-11-21 10:22:42.597686',NULL);
INSERT INTO "sweeps" VALUES(5,'d7d30ba838794583bd5194f1ff82436c','joined','joined','thin_plate','{"name": "joined", "runs": ["0000000000000000000000000000001e", "0000000000000000000000000000001f", "00000000000000000000000000000020"]}','bd6bf5a2fbc3a179db7b5a7b801fa4771e93a75eb15f167e91953d3128ec52fa',3,0,'2026-11-21 10:22:42.635672',NULL);
INSERT INTO "sweeps" VALUES(6,'34e7d5d0dce14215862639a471310a0c','two-speeds','two-speeds','thin_plate','{"name": "two-speeds", "title": "two-speeds", "scenario": "thin_plate", "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm", "plate_thickness": "2 mm"}, "axes": {"speed": ["3 km/s", "6 km/s"]}, "combine": "grid", "resolution": 8.0}','612b8d1d0a4dac9ca58937eca1076d7b55559039ef399f4b0f3949830bd55a69',2,2,'2026-11-21 10:22:43.733281',NULL);
CREATE INDEX sweeps_digest ON sweeps (digest);
CREATE INDEX jobs_queue ON jobs (state, priority, queued, ordinal);
CREATE INDEX points_run ON points (run_id, sweep_id);
CREATE INDEX events_sweep ON events (sweep_id, number);
CREATE INDEX events_job ON events (job_id, number);
DELETE FROM "sqlite_sequence";
INSERT INTO "sqlite_sequence" VALUES('dispatchers',2);
INSERT INTO "sqlite_sequence" VALUES('sweeps',6);
INSERT INTO "sqlite_sequence" VALUES('events',26);
COMMIT;
