-- Since when and until when each relation held: what follows from the frames, kept so that it is not derived twice.
-- It may be emptied at any time; it is then derived again. The same text in DuckDB and in PostgreSQL.

CREATE TABLE derivation (            -- one row, once anything was derived
    rules varchar NOT NULL,          -- digest of the rules and of the program that derived it
    turn bigint NOT NULL             -- counts how often anything was
);

-- The frames that what is kept rests on.
CREATE TABLE accounted (frame bigint NOT NULL);

-- What held, from since on and before until: seconds since the epoch, each the stamp of a frame.
CREATE TABLE held (
    relation varchar NOT NULL,
    figure varchar NOT NULL,
    reference varchar NOT NULL,
    view varchar,                    -- null where none matters
    since double precision NOT NULL,
    until double precision NOT NULL
);

-- What holds by the last frame that is accounted for.
CREATE TABLE holding (
    relation varchar NOT NULL,
    figure varchar NOT NULL,
    reference varchar NOT NULL,
    view varchar,
    since double precision NOT NULL
);

CREATE VIEW lasting AS
SELECT relation, figure, reference, view, since, until FROM held
UNION ALL
SELECT relation, figure, reference, view, since, CAST(NULL AS double precision) FROM holding;
