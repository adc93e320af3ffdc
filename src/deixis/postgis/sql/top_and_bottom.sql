-- Table 1(a), row 3. Minimum oriented box, s -> top and bottom halfspaces: ST_Extrude (axioms 20, 26, 27).
--
-- Of each direction three solids, one above the other: "beyond" the face by more than D, "flush" from D before the
-- face, and "back", all that lies farther back than that (decision 0009).
CREATE TEMPORARY TABLE top_and_bottom AS
SELECT thing, direction, depth,
       CASE WHEN depth >= d THEN
           pg_temp.raised(thick_plan, CASE direction WHEN 0 THEN top + d ELSE bottom - depth END, depth - d)
       END AS beyond,
       pg_temp.raised(thick_plan, CASE direction WHEN 0 THEN top - d ELSE bottom - depth END, depth + d) AS flush,
       pg_temp.raised(ST_Expand(thick_plan, far), CASE direction WHEN 0 THEN top - d - far ELSE bottom + d END, far)
           AS back
FROM threshold, minimum_box
CROSS JOIN (VALUES (0), (1)) AS way (direction)
CROSS JOIN LATERAL (SELECT CASE kind WHEN 'level' THEN far ELSE 2 * s * tz END AS depth OFFSET 0) AS deep;

CREATE UNIQUE INDEX ON top_and_bottom (thing, direction);
