-- Table 1(a), row 8. Minimum oriented boxes -> inter: ST_3DIntersection, and its ST_Volume (axiom 18).
--
-- The same for both orders of a pair, so asked once; what is no solid shares no volume.
CREATE TEMPORARY TABLE inter AS
SELECT figure AS one, reference AS other, {volume}({intersection}(a.solid, b.solid)) AS volume
FROM overlap
JOIN minimum_box AS a ON a.thing = figure
JOIN minimum_box AS b ON b.thing = reference
WHERE figure < reference AND separation < -1e-9 AND least(a.hx, a.hy, a.hz, b.hx, b.hy, b.hz) > 0;

CREATE UNIQUE INDEX ON inter (one, other);
