-- The semantic map of section 4.1 of the paper: what was told, frame by frame. Nothing is ever changed or
-- deleted, so that the state of any time can be read. The same text makes the map in DuckDB and in PostgreSQL.

CREATE TABLE map (
    id varchar PRIMARY KEY,
    thresholds varchar NOT NULL,     -- JSON: only those that differ from the defaults
    strays varchar NOT NULL
);

CREATE TABLE frame (
    seq bigint PRIMARY KEY,          -- in the order of arrival
    stamp double precision NOT NULL, -- seconds since the epoch: when it was so
    source varchar NOT NULL,         -- id of the scene
    whole boolean NOT NULL           -- whether what it does not name was gone
);

-- One row for each thing of each frame: the record of the paper.
CREATE TABLE thing (
    frame bigint NOT NULL REFERENCES frame (seq),
    position integer NOT NULL,       -- in the frame
    id varchar NOT NULL,
    gone boolean NOT NULL,           -- told to be there no more; then all that follows is null
    kind varchar,
    label varchar,                   -- the best one
    labels varchar,                  -- JSON: at most five, with their scores, best first
    x double precision, y double precision, z double precision,    -- minimum bounding box: centre, metres
    hx double precision, hy double precision, hz double precision, -- half extents
    yaw double precision,
    region varchar,                  -- JSON: the region as it was told, in scene format v1
    PRIMARY KEY (frame, position)
);

-- Where the robot, or anyone, was and looked.
CREATE TABLE viewpoint (
    frame bigint NOT NULL REFERENCES frame (seq),
    position integer NOT NULL,
    id varchar NOT NULL,
    label varchar NOT NULL,
    x double precision NOT NULL, y double precision NOT NULL, z double precision NOT NULL,
    heading double precision NOT NULL,
    stamp double precision,
    PRIMARY KEY (frame, position)
);

-- Numbers of frames: writers at the same time are given them in turn.
CREATE SEQUENCE frame_seq;

CREATE INDEX thing_id ON thing (id);
CREATE INDEX frame_stamp ON frame (stamp);
