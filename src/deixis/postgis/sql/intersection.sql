-- Table 1(a), row 8. Minimum oriented boxes -> inter: ST_3DIntersection, and its ST_Volume (axiom 18).
--
-- The same for both orders of a pair, so asked once; what is no solid shares no volume. Boxes are prisms: where
-- SFCGAL refuses what it has made itself, it is the area that the plans share times the height.
CREATE TEMPORARY TABLE inter AS
SELECT figure AS one, reference AS other, told IS NULL AS refused,
       coalesce(told, ST_Area(ST_Intersection(a.plan, b.plan)) * (least(a.top, b.top) - greatest(a.bottom, b.bottom)))
           AS volume
FROM overlap
JOIN minimum_box AS a ON a.thing = figure
JOIN minimum_box AS b ON b.thing = reference
CROSS JOIN LATERAL (SELECT pg_temp.shared_volume(a.solid, b.solid) AS told OFFSET 0) AS asked
WHERE figure < reference AND separation < -1e-9 AND least(a.hx, a.hy, a.hz, b.hx, b.hy, b.hz) > 0;

CREATE UNIQUE INDEX ON inter (one, other);
