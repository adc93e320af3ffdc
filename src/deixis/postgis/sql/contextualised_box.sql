-- Table 1(a), row 2. Minimum oriented box and robot -> contextualised box: ST_Rotate, ST_Angle, ST_Centroid
-- (axiom 12).
--
-- The box is turned by the least angle to the line of sight; where two are equally small its longer side comes to
-- lie across. A surface keeps its plane: a wall's X axis is its normal, away from the view, a level one's the own
-- axis nearest to the line of sight. In the view 0 the line of sight is the world's X axis.
CREATE TEMPORARY TABLE contextualised_box AS
SELECT view, thing, x, y, z, bottom, top, tz,
       CASE WHEN surface THEN thick_plan ELSE ST_Rotate(thick_plan, turn, ST_Centroid(thick_plan)) END AS plan,
       CASE WHEN wall_seen THEN yaw + CASE WHEN ahead > 0 THEN -0.5 * pi() ELSE 0.5 * pi() END
            WHEN surface THEN yaw + quarters * 0.5 * pi()
            ELSE yaw + turn + quarters * 0.5 * pi() END AS yaw,
       CASE WHEN crossed THEN hy ELSE hx END AS fx, CASE WHEN crossed THEN hx ELSE hy END AS fy,
       CASE WHEN crossed THEN ty ELSE tx END AS tx, CASE WHEN crossed THEN tx ELSE ty END AS ty,
       -- The axis along which the halfspaces have no end: an upright surface's normal is its shorter side.
       CASE WHEN kind = 'upright' THEN CASE WHEN crossed THEN 0 ELSE 1 END END AS endless,
       CASE WHEN place IS NULL THEN true
            WHEN kind = 'upright' THEN abs(ahead) - hy > 1e-9
            ELSE ST_Distance(plan, place) > 1e-9 END AS spoken_of,
       tie AND NOT coalesce(wall_seen, false) AS ambiguous
FROM viewpoint CROSS JOIN minimum_box
CROSS JOIN LATERAL (SELECT
    kind = 'upright' AND place IS NOT NULL AS wall_seen,
    -- How far the view lies along the box's own Y axis.
    ST_Y(pg_temp.seen(place, yaw, x, y)) AS ahead,
    -- ST_Angle counts clockwise.
    -coalesce(ST_Angle(
        ST_MakeLine(ST_MakePoint(x, y), ST_MakePoint(x + cos(yaw), y + sin(yaw))),
        CASE WHEN place IS NULL THEN ST_MakeLine(ST_MakePoint(0, 0), ST_MakePoint(1, 0))
             ELSE ST_MakeLine(place, ST_MakePoint(x, y)) END), yaw) AS angle OFFSET 0) AS sight
CROSS JOIN LATERAL (SELECT
    round(angle / (0.5 * pi())) AS nearest OFFSET 0) AS rounded
CROSS JOIN LATERAL (SELECT
    abs(abs(angle - nearest * 0.5 * pi()) - 0.25 * pi()) < 1e-7 AND hx - hy > 1e-7 * hx AS tie OFFSET 0) AS even
CROSS JOIN LATERAL (SELECT
    nearest + CASE WHEN NOT tie OR nearest::bigint % 2 <> 0 THEN 0
                   ELSE sign(angle - nearest * 0.5 * pi()) END AS quarters OFFSET 0) AS chosen
CROSS JOIN LATERAL (SELECT
    angle - quarters * 0.5 * pi() AS turn, wall_seen OR quarters::bigint % 2 <> 0 AS crossed OFFSET 0) AS turned;

CREATE UNIQUE INDEX ON contextualised_box (thing, view);
ANALYZE contextualised_box;
