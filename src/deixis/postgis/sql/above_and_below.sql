-- Table 1(a), row 10, the vertical. Minimum oriented box, top and bottom halfspaces -> Above, Below: ST_3DIntersects.
--
-- Of two things in contact the figure is beyond the face that the contact is on: the way out through it is the
-- shortest (decision 0009). Else the figure meets "beyond", or begins within "flush" where it does not intersect the
-- reference. The operator says whether; how far that is from changing is measured from the same extents, which also
-- decide what is within a nanometre of the bound.
CREATE TEMPORARY TABLE vertical AS
SELECT figure, reference, direction, meets, margin, relaxed,
       least(relaxed,
             d - greatest(ST_XMax(here) - b.tx, -b.tx - ST_XMin(here), ST_YMax(here) - b.ty, -b.ty - ST_YMin(here)),
             near + d, depth + d - far_end) AS strict
FROM threshold, overlap
JOIN minimum_box AS a ON a.thing = figure
JOIN minimum_box AS b ON b.thing = reference
JOIN top_and_bottom ON top_and_bottom.thing = reference
CROSS JOIN LATERAL (SELECT
    pg_temp.seen(a.thick_plan, b.yaw, b.x, b.y) AS here,
    separation < -p AS deep,
    separation BETWEEN -p AND d AS contact,
    -- From the face outwards.
    CASE direction WHEN 0 THEN a.bottom - b.top ELSE b.bottom - a.top END AS near,
    CASE direction WHEN 0 THEN a.top - b.top ELSE b.bottom - a.bottom END AS far_end,
    CASE direction WHEN 0 THEN up ELSE down END AS escape, CASE direction WHEN 0 THEN down ELSE up END AS other
    OFFSET 0) AS measured
CROSS JOIN LATERAL (SELECT least(
    across - 0.5 * d, depth - near,
    CASE WHEN NOT contact THEN CASE WHEN deep THEN far_end - d ELSE greatest(near + d, far_end - d) END
         WHEN escape = 'infinity' THEN near
         ELSE least(across, p, other) - escape END) AS margin OFFSET 0) AS size
CROSS JOIN LATERAL (SELECT
    across >= 0.5 * d AND (
        coalesce(ST_3DIntersects(a.slab, beyond), false)
        OR (NOT deep AND ST_3DIntersects(a.slab, flush) AND NOT ST_3DIntersects(a.slab, back))) AS meets
    OFFSET 0) AS asked
CROSS JOIN LATERAL (SELECT
    CASE WHEN contact OR abs(margin) < 1e-9 THEN margin WHEN meets THEN greatest(margin, 0) ELSE least(margin, -1e-9)
    END AS relaxed OFFSET 0) AS decided;

CREATE UNIQUE INDEX ON vertical (figure, reference, direction);
