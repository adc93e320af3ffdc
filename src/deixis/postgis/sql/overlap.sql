-- Table 1(a), row 7. Minimum oriented boxes -> Int, and with it Touches: ST_3DIntersects (axioms 16, 17).
--
-- Apart, the separation is the distance. Overlapping, it is minus the least way out: sideways through one of the two
-- boxes' faces, found from their extents in each other's frames (ST_Rotate), or up or down. What lies within a
-- thing has no way out through its bottom, nor the thing through its content's top (decision 0004).
CREATE TEMPORARY TABLE overlap AS
SELECT figure, reference, ordered, protrusion AS sticks_out, thick AS across, up, down, intersects,
       round(CASE WHEN NOT intersects THEN distance ELSE -least(sideways, up, down) END::numeric, 9)::float8
           AS separation,
       CASE WHEN NOT intersects THEN ARRAY[
                ST_X(ST_EndPoint(shortest)) - ST_X(ST_StartPoint(shortest)),
                ST_Y(ST_EndPoint(shortest)) - ST_Y(ST_StartPoint(shortest)),
                ST_Z(ST_EndPoint(shortest)) - ST_Z(ST_StartPoint(shortest))]
            WHEN least(up, down) <= sideways THEN ARRAY[0, 0, CASE WHEN up <= down THEN 1 ELSE -1 END]
            ELSE ARRAY[cos(way), sin(way), 0] END AS normal
FROM threshold, near
JOIN minimum_box AS a ON a.thing = figure
JOIN minimum_box AS b ON b.thing = reference
CROSS JOIN LATERAL (SELECT
    -- Half a nanometre apart is not apart.
    distance < 0.5e-9 OR ST_3DIntersects(a.solid, b.solid) AS intersects,
    pg_temp.seen(a.plan, b.yaw, b.x, b.y) AS a_in_b, pg_temp.seen(a.thick_plan, b.yaw, b.x, b.y) AS thick_a_in_b,
    pg_temp.seen(b.plan, a.yaw, a.x, a.y) AS b_in_a, pg_temp.seen(b.thick_plan, a.yaw, a.x, a.y) AS thick_b_in_a
    OFFSET 0) AS plans
CROSS JOIN LATERAL (SELECT
    pg_temp.common(ST_XMin(a_in_b), ST_XMax(a_in_b), b.hx) AS of_b_x,
    pg_temp.common(ST_YMin(a_in_b), ST_YMax(a_in_b), b.hy) AS of_b_y,
    pg_temp.common(ST_XMin(b_in_a), ST_XMax(b_in_a), a.hx) AS of_a_x,
    pg_temp.common(ST_YMin(b_in_a), ST_YMax(b_in_a), a.hy) AS of_a_y,
    least(pg_temp.common(ST_XMin(thick_a_in_b), ST_XMax(thick_a_in_b), b.tx),
          pg_temp.common(ST_YMin(thick_a_in_b), ST_YMax(thick_a_in_b), b.ty),
          pg_temp.common(ST_XMin(thick_b_in_a), ST_XMax(thick_b_in_a), a.tx),
          pg_temp.common(ST_YMin(thick_b_in_a), ST_YMax(thick_b_in_a), a.ty)) AS thick,
    greatest(ST_XMax(a_in_b) - b.hx, -b.hx - ST_XMin(a_in_b), ST_YMax(a_in_b) - b.hy, -b.hy - ST_YMin(a_in_b),
             a.top - b.top, b.bottom - a.bottom) AS protrusion,
    greatest(ST_XMax(b_in_a) - a.hx, -a.hx - ST_XMin(b_in_a), ST_YMax(b_in_a) - a.hy, -a.hy - ST_YMin(b_in_a),
             b.top - a.top, a.bottom - b.bottom) AS protrusion_back,
    ST_Centroid(a_in_b) AS a_centre, ST_Centroid(b_in_a) AS b_centre OFFSET 0) AS extents
CROSS JOIN LATERAL (SELECT
    least(of_b_x, of_b_y, of_a_x, of_a_y) AS sideways,
    NOT b.surface AND abs(a.z - b.z) + 1e-9 <= b.hz AND protrusion <= d + 1e-9 AS within,
    NOT a.surface AND abs(a.z - b.z) + 1e-9 <= a.hz AND protrusion_back <= d + 1e-9 AS holds OFFSET 0) AS depth
CROSS JOIN LATERAL (SELECT
    CASE WHEN holds AND NOT within THEN 'infinity' ELSE b.top - a.bottom END AS up,
    CASE WHEN within AND NOT holds THEN 'infinity' ELSE a.top - b.bottom END AS down,
    -- The direction, from reference to figure, of the face that is the way out.
    CASE sideways
        WHEN of_b_x THEN b.yaw + CASE WHEN ST_X(a_centre) < 0 THEN pi() ELSE 0 END
        WHEN of_b_y THEN b.yaw + CASE WHEN ST_Y(a_centre) < 0 THEN -0.5 * pi() ELSE 0.5 * pi() END
        WHEN of_a_x THEN a.yaw + CASE WHEN ST_X(b_centre) < 0 THEN 0 ELSE pi() END
        ELSE a.yaw + CASE WHEN ST_Y(b_centre) < 0 THEN 0.5 * pi() ELSE -0.5 * pi() END END AS way OFFSET 0) AS escape;

CREATE UNIQUE INDEX ON overlap (figure, reference);
ANALYZE overlap;
