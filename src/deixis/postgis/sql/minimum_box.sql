-- Table 1(a), row 1. Convex hull -> minimum oriented box: ST_OrientedEnvelope, ST_ZMin, ST_ZMax, ST_Extrude.
--
-- ST_OrientedEnvelope refuses a polyhedron, so it is given its corners. Its longer side is the box's X axis. A side
-- below a nanometre is none, so that a wall's plan is a line whatever way it was turned. "grain" is the box with no
-- side thinner than D, "slab" has only its plan so.
CREATE TEMPORARY TABLE minimum_box AS
SELECT thing, kind, kind <> 'thing' AS surface, x, y, bottom, top, hx, hy, 0.5 * (top - bottom) AS hz, yaw,
       greatest(hx, 0.5 * d) AS tx, greatest(hy, 0.5 * d) AS ty, greatest(0.5 * (top - bottom), 0.5 * d) AS tz,
       0.5 * (bottom + top) AS z, plan, thick_plan,
       pg_temp.raised(plan, bottom, top - bottom) AS solid,
       pg_temp.raised(thick_plan, bottom, top - bottom) AS slab,
       pg_temp.raised(thick_plan, least(bottom, 0.5 * (bottom + top - d)), greatest(top - bottom, d)) AS grain
FROM threshold, hull
CROSS JOIN LATERAL (SELECT
    ST_OrientedEnvelope(ST_Force2D(ST_Points(region))) AS fitted, ST_ZMin(region) AS bottom, ST_ZMax(region) AS top
    OFFSET 0) AS envelope
CROSS JOIN LATERAL (SELECT
    -- Three corners one after the other; of a line its ends, of a point itself.
    CASE ST_Dimension(fitted) WHEN 2 THEN ST_PointN(ST_ExteriorRing(fitted), 1)
         WHEN 1 THEN ST_StartPoint(fitted) ELSE fitted END AS one,
    CASE ST_Dimension(fitted) WHEN 2 THEN ST_PointN(ST_ExteriorRing(fitted), 2)
         WHEN 1 THEN ST_EndPoint(fitted) ELSE fitted END AS two,
    CASE ST_Dimension(fitted) WHEN 2 THEN ST_PointN(ST_ExteriorRing(fitted), 3)
         WHEN 1 THEN ST_EndPoint(fitted) ELSE fitted END AS three OFFSET 0) AS corner
CROSS JOIN LATERAL (SELECT
    ST_Centroid(ST_MakeLine(one, three)) AS middle,
    ST_Distance(one, two) AS first, ST_Distance(two, three) AS second OFFSET 0) AS side
CROSS JOIN LATERAL (SELECT
    ST_X(middle) AS x, ST_Y(middle) AS y,
    CASE WHEN greatest(first, second) < 1e-9 THEN 0 ELSE 0.5 * greatest(first, second) END AS hx,
    CASE WHEN least(first, second) < 1e-9 THEN 0 ELSE 0.5 * least(first, second) END AS hy,
    coalesce(0.5 * pi() - CASE WHEN first >= second THEN ST_Azimuth(one, two) ELSE ST_Azimuth(two, three) END, 0)
        AS yaw OFFSET 0) AS measured
CROSS JOIN LATERAL (SELECT
    pg_temp.rectangle(-hx, -hy, hx, hy, yaw, x, y) AS plan,
    pg_temp.rectangle(-greatest(hx, 0.5 * d), -greatest(hy, 0.5 * d), greatest(hx, 0.5 * d), greatest(hy, 0.5 * d),
                      yaw, x, y) AS thick_plan OFFSET 0) AS drawn;

CREATE INDEX ON minimum_box USING gist (solid gist_geometry_ops_nd);
CREATE UNIQUE INDEX ON minimum_box (thing);
ANALYZE minimum_box;
