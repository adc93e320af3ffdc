-- Table 1(a), row 11. Minimum oriented boxes -> adjSRCard, and with it PartIn: ST_Scale, ST_Intersection, ST_Volume
-- (axioms 39, 40).
--
-- inter is scaled, along the reference's axes, until it is D larger on each side. The points of the figure adjacent to
-- inter are those of the figure in what was gained; their measure is its volume. Boxes being prisms, the
-- regions are intersected as plans, to the nanometre, and extruded.
CREATE TEMPORARY TABLE frontier AS
SELECT figure, reference,
       {volume}(pg_temp.raised(ST_Intersection(grown, a_here, 1e-9), 0, a_height))
       - {volume}(pg_temp.raised(shared, 0, height)) AS frontier
FROM threshold, overlap
JOIN minimum_box AS a ON a.thing = figure
JOIN minimum_box AS b ON b.thing = reference
CROSS JOIN LATERAL (SELECT
    -- The same frame for both orders of a pair: that of the thing that comes first.
    pg_temp.seen(a.thick_plan, frame.yaw, frame.x, frame.y) AS a_here,
    pg_temp.seen(b.thick_plan, frame.yaw, frame.x, frame.y) AS b_here,
    least(a.z + a.tz, b.z + b.tz) AS high, greatest(a.z - a.tz, b.z - b.tz) AS low
    FROM minimum_box AS frame WHERE frame.thing = least(figure, reference) OFFSET 0) AS placed
CROSS JOIN LATERAL (SELECT
    ST_Intersection(a_here, b_here, 1e-9) AS shared, high - low AS height,
    least(high + d, a.z + a.tz) - greatest(low - d, a.z - a.tz) AS a_height OFFSET 0) AS inter
CROSS JOIN LATERAL (SELECT
    ST_Scale(shared,
             ST_MakePoint(1 + 2 * d / (ST_XMax(shared) - ST_XMin(shared)),
                          1 + 2 * d / (ST_YMax(shared) - ST_YMin(shared))),
             ST_Centroid(shared)) AS grown OFFSET 0) AS scaled
WHERE separation < -1e-9 AND ST_Dimension(shared) = 2 AND height > 0;

CREATE UNIQUE INDEX ON frontier (figure, reference);
