-- Table 1(a), row 6. Minimum oriented boxes -> IsClose: ST_3DDWithin (axioms 14, 15).
--
-- Kept is what is close, and in figure-reference order also what a halfspace of the reference may extend to. Half a
-- nanometre is added since lengths are rounded to a nanometre before they are compared. Of two rods in one place
-- PostGIS knows no distance: null stands for 0.
CREATE TEMPORARY TABLE near AS
WITH reach AS MATERIALIZED (
    SELECT minimum_box.*, ST_Expand(solid, greatest(farthest, t)) AS around, t + 0.5e-9 AS close,
           greatest(farthest, t) + 1e-6 AS farthest
    FROM threshold, minimum_box
    CROSS JOIN LATERAL (SELECT CASE WHEN surface THEN far
        ELSE greatest(2 * s * greatest(tx, ty) + sqrt(tx * tx + ty * ty), 2 * s * tz) END AS farthest
    OFFSET 0) AS sweep)
SELECT a.thing AS figure, b.thing AS reference, ordered, coalesce(ST_3DDistance(a.solid, b.solid), 0) AS distance,
       ST_3DShortestLine(b.solid, a.solid) AS shortest
FROM minimum_box AS a
JOIN reach AS b ON a.thing <> b.thing AND a.solid &&& b.around
JOIN reference_order ON figure = a.thing AND reference = b.thing
WHERE ST_3DDWithin(a.solid, b.solid, CASE WHEN ordered THEN greatest(farthest, close) ELSE close END)
   OR ST_3DDistance(a.solid, b.solid) IS NULL;

CREATE UNIQUE INDEX ON near (figure, reference);
ANALYZE near;
