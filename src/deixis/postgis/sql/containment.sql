-- Table 1(a), row 9. Minimum oriented boxes -> ComplCont: the volume of inter against that of the content (axiom 19).
--
-- The volumes decide whether the figure sticks out of the reference at all, to a billionth; how far, its extents say.
CREATE TEMPORARY TABLE containment AS
SELECT figure, reference, inter.volume AS intersection,
       inter.volume >= (1 - 1e-9) * own.volume AS contained,
       CASE WHEN inter.volume >= (1 - 1e-9) * own.volume THEN least(sticks_out, 0) ELSE sticks_out END AS protrusion
FROM overlap
LEFT JOIN inter ON one = least(figure, reference) AND other = greatest(figure, reference)
LEFT JOIN size AS own ON own.thing = figure AND one IS NOT NULL;

CREATE UNIQUE INDEX ON containment (figure, reference);
