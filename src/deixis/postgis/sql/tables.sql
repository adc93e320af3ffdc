-- What the rows of Table 1(a) work on. All of it is temporary and filled by COPY: nothing of a scene is ever in
-- the text of a statement. In all files OFFSET 0 keeps PostgreSQL from computing a column anew wherever it is named.

CREATE TEMPORARY TABLE threshold (
    d float8,                        -- granularity, metres
    p float8,                        -- penetration
    t float8,                        -- closeness
    s float8,                        -- halfspace scale
    far float8                       -- farther than anything is: how deep a halfspace without end is made
);

CREATE TEMPORARY TABLE hull (
    thing integer PRIMARY KEY,       -- position in the scene
    kind text,                       -- thing; or level or upright, for a surface
    region geometry                  -- convex hull; of a surface its rectangle
);

CREATE TEMPORARY TABLE viewpoint (
    view integer PRIMARY KEY,        -- 0: the world's own axes
    place geometry                   -- null for the world
);

-- A plan view raised by a height: a solid, or less where the plan or the height is nothing. Below a nanometre is
-- nothing, here and below, since SFCGAL refuses slivers.
CREATE OR REPLACE FUNCTION pg_temp.raised(plan geometry, bottom float8, height float8) RETURNS geometry
LANGUAGE sql IMMUTABLE AS $$
    SELECT CASE
        WHEN height < 1e-9 THEN ST_Force3D(plan, bottom)
        WHEN ST_Dimension(plan) < 2 THEN {extrude}(ST_Force3D(plan, bottom), 0, 0, height)
        ELSE {makesolid}({extrude}(ST_Force3D(plan, bottom), 0, 0, height)) END
$$;

-- The level rectangle with corners x0, y0 and x1, y1, turned about the origin, then moved; it may be a line or a point.
CREATE OR REPLACE FUNCTION pg_temp.rectangle(
    x0 float8, y0 float8, x1 float8, y1 float8, turn float8, east float8, north float8) RETURNS geometry
LANGUAGE sql IMMUTABLE AS $$
    SELECT ST_Translate(ST_Rotate(ST_Envelope(ST_MakeLine(
        ST_MakePoint(x0, y0),
        ST_MakePoint(CASE WHEN x1 - x0 < 1e-9 THEN x0 ELSE x1 END, CASE WHEN y1 - y0 < 1e-9 THEN y0 ELSE y1 END))),
        turn), east, north)
$$;

-- A plan view as seen in a frame: turned back about the frame's origin, which becomes 0, 0.
CREATE OR REPLACE FUNCTION pg_temp.seen(plan geometry, turn float8, east float8, north float8) RETURNS geometry
LANGUAGE sql IMMUTABLE AS $$
    SELECT ST_Rotate(ST_Translate(plan, -east, -north), -turn)
$$;

-- How deep the interval from low to high reaches into -half to half; negative where they are apart.
CREATE OR REPLACE FUNCTION pg_temp.common(low float8, high float8, half float8) RETURNS float8
LANGUAGE sql IMMUTABLE AS $$
    SELECT least(high + half, half - low)
$$;

-- The volume of what two solids share; null where SFCGAL refuses what it has made itself, which rounding may spoil.
CREATE OR REPLACE FUNCTION pg_temp.shared_volume(one geometry, other geometry) RETURNS float8
LANGUAGE plpgsql AS $$ BEGIN
    RETURN {volume}({intersection}(one, other));
EXCEPTION WHEN internal_error THEN
    RETURN NULL;
END $$;
