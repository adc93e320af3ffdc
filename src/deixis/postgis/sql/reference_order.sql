-- Table 1(a), row 5. Minimum oriented boxes -> reference object set: ST_Volume.
--
-- A surface is a reference, and so is what is not the smaller; equal up to a millionth, each is one of the other.
CREATE TEMPORARY TABLE size AS
SELECT thing, surface, {volume}(grain) AS volume FROM minimum_box;

CREATE TEMPORARY TABLE reference_order AS
SELECT a.thing AS figure, b.thing AS reference,
       NOT a.surface AND (b.surface OR b.volume >= a.volume * (1 - 1e-6)) AS ordered
FROM size AS a CROSS JOIN size AS b;

CREATE UNIQUE INDEX ON reference_order (figure, reference);
