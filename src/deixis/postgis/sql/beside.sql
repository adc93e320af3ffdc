-- Table 1(a), row 10, the horizontal. Minimum oriented box, side halfspaces -> LeftOf, RightOf, InFrontOf, Behind
-- and the cardinal directions: ST_3DIntersects (axioms 30 to 34).
--
-- The figure meets "beyond", or, where it does not intersect the reference, begins within "flush" with its middle on
-- that side. The operator says whether; how far that is from changing is measured from the figure's extents in
-- the halfspace's frame (ST_Rotate), of that part of it which lies across the halfspace (ST_Intersection);
-- what is within a nanometre of the bound is decided by that too.
CREATE TEMPORARY TABLE aspect AS
SELECT view, figure, reference, direction, meets, margin, relaxed,
       least(relaxed,
             width + 1.5 * d - greatest(ST_YMax(here), -ST_YMin(here)),
             side.tz + d - greatest(a.z + a.tz - side.z, side.z - a.z + a.tz),
             ST_XMin(here) - (face - d), face + depth + d - ST_XMax(here)) AS strict
FROM threshold, overlap
JOIN minimum_box AS a ON a.thing = figure
JOIN sides AS side ON side.thing = reference
CROSS JOIN LATERAL (SELECT
    separation < -p AS deep,
    pg_temp.seen(a.thick_plan, turn, side.x, side.y) AS here OFFSET 0) AS placed
CROSS JOIN LATERAL (SELECT
    -- Where nothing of the figure lies across the halfspace, its whole extent.
    CASE WHEN ST_IsEmpty(part) THEN here ELSE part END AS within_reach, ST_X(ST_Centroid(here)) AS middle
    FROM ST_Intersection(here, ST_Envelope(ST_MakeLine(ST_MakePoint(-far, -width), ST_MakePoint(far, width))))
        AS part OFFSET 0) AS cut
CROSS JOIN LATERAL (SELECT least(
    pg_temp.common(ST_YMin(here), ST_YMax(here), width),
    pg_temp.common(a.z - a.tz - side.z, a.z + a.tz - side.z, side.tz - 0.5 * d),
    CASE WHEN deep THEN ST_XMax(within_reach) - (face + d)
         ELSE greatest(least(ST_XMin(within_reach) - (face - d), middle), ST_XMax(within_reach) - (face + d)) END,
    face + depth - ST_XMin(within_reach)) AS margin OFFSET 0) AS measured
CROSS JOIN LATERAL (SELECT
    coalesce(ST_3DIntersects(a.grain, beyond), false)
    OR (NOT deep AND middle >= 0 AND ST_3DIntersects(a.grain, flush) AND NOT ST_3DIntersects(a.grain, back)) AS meets
    OFFSET 0) AS asked
CROSS JOIN LATERAL (SELECT
    CASE WHEN abs(margin) < 1e-9 THEN margin WHEN meets THEN greatest(margin, 0) ELSE least(margin, -1e-9)
    END AS relaxed OFFSET 0) AS decided
WHERE ordered;

CREATE UNIQUE INDEX ON aspect (view, figure, reference, direction);
