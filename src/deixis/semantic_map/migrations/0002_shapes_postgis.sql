-- Where PostGIS is: each thing's convex hull and minimum bounding box as geometry, so that other programs can ask for
-- things by place. Nothing of ours is read from it; a thing told of before PostGIS was there has none.

CREATE TABLE shape (
    frame bigint NOT NULL,
    position integer NOT NULL,       -- as in thing
    hull geometry NOT NULL,          -- world frame, metres: a polyhedral surface; of what is flat a polygon
    box geometry NOT NULL,
    PRIMARY KEY (frame, position),
    FOREIGN KEY (frame, position) REFERENCES thing (frame, position)
);

CREATE INDEX shape_hull ON shape USING gist (hull gist_geometry_ops_nd);
CREATE INDEX shape_box ON shape USING gist (box gist_geometry_ops_nd);
