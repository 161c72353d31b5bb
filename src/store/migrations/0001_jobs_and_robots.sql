-- Times are microseconds since 1970; labels, progress, error and kind are JSON.
CREATE TABLE jobs (
    number          INTEGER PRIMARY KEY AUTOINCREMENT, -- order of acceptance, never used twice
    id              TEXT    NOT NULL UNIQUE,
    state           TEXT    NOT NULL,
    priority        INTEGER NOT NULL,
    short           INTEGER NOT NULL,
    task            TEXT    NOT NULL,
    method          TEXT    NOT NULL,
    robot           TEXT    NOT NULL,
    seed            INTEGER NOT NULL,                  -- the 64 bits of an unsigned number
    labels          TEXT    NOT NULL,
    created_at      INTEGER NOT NULL,
    started_at      INTEGER,
    finished_at     INTEGER,
    deadline_s      REAL,
    start_by        INTEGER,
    attempt         INTEGER NOT NULL DEFAULT 0,
    claim           INTEGER NOT NULL DEFAULT 0,        -- starts so far; fences late results
    last_seq        INTEGER NOT NULL DEFAULT 0,
    progress        TEXT,
    error           TEXT,
    idempotency_key TEXT    UNIQUE,
    body_sha256     BLOB
) STRICT;
CREATE INDEX jobs_by_state ON jobs (state, number);
CREATE INDEX jobs_by_end ON jobs (finished_at) WHERE finished_at IS NOT NULL;

CREATE TABLE labels (
    key   TEXT    NOT NULL,
    value TEXT    NOT NULL,
    job   INTEGER NOT NULL REFERENCES jobs (number) ON DELETE CASCADE,
    PRIMARY KEY (key, value, job)
) STRICT, WITHOUT ROWID;
CREATE INDEX labels_by_job ON labels (job);

-- Apart from the jobs, so that listing those reads no large texts.
CREATE TABLE requests (
    job  INTEGER PRIMARY KEY REFERENCES jobs (number) ON DELETE CASCADE,
    body TEXT    NOT NULL
) STRICT;
CREATE TABLE results (
    job  INTEGER PRIMARY KEY REFERENCES jobs (number) ON DELETE CASCADE,
    body TEXT    NOT NULL
) STRICT;

CREATE TABLE events (
    job  INTEGER NOT NULL REFERENCES jobs (number) ON DELETE CASCADE,
    seq  INTEGER NOT NULL,
    time INTEGER NOT NULL,
    kind TEXT    NOT NULL,
    PRIMARY KEY (job, seq)
) STRICT, WITHOUT ROWID;

CREATE TABLE robots (
    name TEXT PRIMARY KEY,
    body TEXT NOT NULL
) STRICT, WITHOUT ROWID;
