-- Table 1(a), row 4. Contextualised box, s -> left, right, front and back halfspaces: ST_Extrude (axioms 20, 30).
--
-- Solids as in top_and_bottom.sql, along X+, X-, Y+, Y- of the contextualised box. They are D/2 narrower on each side:
-- a smaller common part of the cross-sections is none.
CREATE TEMPORARY TABLE sides AS
SELECT view, thing, direction, turn, x, y, z, tz, face, width, depth,
       CASE WHEN depth >= d THEN
           pg_temp.raised(pg_temp.rectangle(face + d, -width, face + depth, width, turn, x, y), low, height)
       END AS beyond,
       pg_temp.raised(pg_temp.rectangle(face - d, -width, face + depth, width, turn, x, y), low, height) AS flush,
       pg_temp.raised(pg_temp.rectangle(-far, -width, face - d, width, turn, x, y), low, height) AS back
FROM threshold, contextualised_box
CROSS JOIN (VALUES (0, 0, 0), (1, 0, 1), (2, 1, 0), (3, 1, 1)) AS way (direction, axis, away)
CROSS JOIN LATERAL (SELECT
    yaw + axis * 0.5 * pi() + away * pi() AS turn,
    CASE axis WHEN 0 THEN fx ELSE fy END AS face,
    CASE axis WHEN 0 THEN ty ELSE tx END - 0.5 * d AS width,
    CASE WHEN endless = axis THEN far ELSE 2 * s * CASE axis WHEN 0 THEN tx ELSE ty END END AS depth,
    z - tz + 0.5 * d AS low, 2 * tz - d AS height OFFSET 0) AS measured
WHERE spoken_of;

CREATE UNIQUE INDEX ON sides (thing, view, direction);
ANALYZE sides;
