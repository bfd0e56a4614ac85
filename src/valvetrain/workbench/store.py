"""The database of a workspace: one SQLite file in WAL mode, a connection for each use, so that threads and restarts do not matter."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from valvetrain.errors import InputError

DATABASE = "workbench.sqlite"
_TABLES = """
CREATE TABLE IF NOT EXISTS cases (name TEXT PRIMARY KEY, origin TEXT NOT NULL, created_at TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS choices (name TEXT NOT NULL, key TEXT NOT NULL, value TEXT NOT NULL, PRIMARY KEY (name, key));
CREATE TABLE IF NOT EXISTS jobs (
    id TEXT PRIMARY KEY, case_name TEXT NOT NULL, kind TEXT NOT NULL, request TEXT NOT NULL, state TEXT NOT NULL,
    share REAL NOT NULL DEFAULT 0, text TEXT NOT NULL DEFAULT '', seconds_left REAL, error TEXT NOT NULL DEFAULT '',
    run_id TEXT NOT NULL DEFAULT '', created_at REAL NOT NULL, started_at REAL, ended_at REAL
);
CREATE INDEX IF NOT EXISTS jobs_by_case ON jobs (case_name, created_at);
CREATE INDEX IF NOT EXISTS jobs_by_run ON jobs (run_id);
"""
#: Layout of the tables above; a file of another layout is refused, never guessed at.
_LAYOUT = 1


class Store:
    """The SQLite file of a workspace.

    Parameters
    ----------
    folder : folder of the workspace

    Raises
    ------
    InputError : a file that is no such database, or of another layout
    """

    def __init__(self, folder: Path) -> None:
        self.path = folder / DATABASE
        try:
            with self.connected() as base:
                base.execute("PRAGMA journal_mode=WAL")
                (found,) = base.execute("PRAGMA user_version").fetchone()
                if found not in (0, _LAYOUT):
                    raise InputError(f"was written by another version (layout {found}); use that version, or another folder", DATABASE)
                base.executescript(_TABLES)
                base.execute(f"PRAGMA user_version={_LAYOUT}")
        except sqlite3.Error as error:
            raise InputError(f"cannot be used ({error}); move it away, the cases and runs beside it stay", DATABASE) from None

    @contextmanager
    def connected(self) -> Iterator[sqlite3.Connection]:
        """A connection whose changes are kept when the block ends well, all or none."""
        base = sqlite3.connect(self.path, timeout=10.0)
        base.row_factory = sqlite3.Row
        try:
            base.execute("PRAGMA synchronous=NORMAL")
            with base:
                yield base
        finally:
            base.close()
