"""A PostgreSQL server of our own with PostGIS and SFCGAL, for as long as a test or a benchmark needs it.

It lives in a folder that only its owner can enter, listens on a Unix socket there and on no port, and
leaves nothing behind. PostgreSQL refuses to run as root, so for root it runs as the user ``postgres``.
"""

from __future__ import annotations

import os
import pwd
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from deixis.errors import MissingDependency

REMEDY = "on Debian and Ubuntu: sudo apt install postgresql-postgis"

DEBIAN = Path("/usr/lib/postgresql")
"""Where Debian keeps the programs of each version of PostgreSQL."""

SETTINGS = {
    "listen_addresses": "",
    "fsync": "off",
    "full_page_writes": "off",
    "synchronous_commit": "off",
    "shared_buffers": "128MB",
    "work_mem": "64MB",
    # Compiling a statement takes longer than it saves on a hundred things.
    "jit": "off",
}


class PostgisUnavailable(MissingDependency):
    """No PostgreSQL with PostGIS and SFCGAL can be started here; the message says why."""


@contextmanager
def postgis() -> Iterator[str]:
    """Start a server with the extensions in it; give what to connect with; stop it.

    Raises
    ------
    PostgisUnavailable
        A program or an extension is missing, or the server does not start.
    """
    # Before anything is started: a server that has only just begun to start is slow to be stopped.
    if find_spec("psycopg") is None:
        raise PostgisUnavailable("psycopg was not found; pip install 'psycopg[binary]'")
    programs = _programs()
    user = _user()
    # The path of a Unix socket may have a hundred characters: not below a test's own temporary folder.
    home = Path(tempfile.mkdtemp(prefix="deixis-", dir="/tmp"))
    try:
        if user:
            owner = pwd.getpwnam(user["user"])
            os.chown(home, owner.pw_uid, owner.pw_gid)
        data = home / "data"
        _run(
            [
                programs / "initdb",
                "-D",
                data,
                "-U",
                "deixis",
                "-A",
                "trust",
                "-E",
                "UTF8",
                "--locale=C",
                "-N",
            ],
            home,
            user,
        )
        options = [f"-c{name}={value}" for name, value in SETTINGS.items()]
        log = home / "log"
        with log.open("wb") as sink:
            server = subprocess.Popen(
                [programs / "postgres", "-D", data, "-k", home, *options],
                cwd=home,
                stdin=subprocess.DEVNULL,
                stdout=sink,
                stderr=subprocess.STDOUT,
                env=_environment(),
                # Not the terminal's Ctrl-C: the server is stopped below, after its clients.
                start_new_session=True,
                **user,
            )
        try:
            address = f"host={home} user=deixis dbname=postgres"
            _prepare(address, server, log)
            yield address
        finally:
            # Immediate shutdown: nothing of it is kept.
            server.send_signal(signal.SIGQUIT)
            server.wait(timeout=30)
    finally:
        shutil.rmtree(home)


def _programs() -> Path:
    """Return the folder of initdb and postgres; with several versions, of the newest that has PostGIS."""
    folders = sorted(DEBIAN.glob("*/bin"), key=lambda folder: -int(folder.parent.name))
    for folder in folders:
        extensions = Path("/usr/share/postgresql", folder.parent.name, "extension")
        if (folder / "initdb").exists() and (extensions / "postgis_sfcgal.control").exists():
            return folder
    found = shutil.which("initdb")
    if found is None:
        raise PostgisUnavailable(f"PostgreSQL with PostGIS and SFCGAL was not found; {REMEDY}")
    return Path(found).resolve().parent


def _user() -> dict[str, Any]:
    """Return how to start a program as one who may run PostgreSQL."""
    if os.getuid() != 0:
        return {}
    try:
        group = pwd.getpwnam("postgres").pw_gid
    except KeyError as cause:
        raise PostgisUnavailable("PostgreSQL does not run as root, and there is no user postgres") from cause
    return {"user": "postgres", "group": group, "extra_groups": ()}


def _environment() -> dict[str, str]:
    """Return the environment without the caller's own settings for PostgreSQL."""
    return {name: value for name, value in os.environ.items() if not name.startswith("PG")}


def _run(command: list[Any], home: Path, user: dict[str, Any]) -> None:
    result = subprocess.run(
        command, cwd=home, env=_environment(), capture_output=True, text=True, check=False, **user
    )
    if result.returncode:
        raise PostgisUnavailable(f"{command[0].name} failed: {result.stderr.strip()[-500:]}")


def _prepare(address: str, server: subprocess.Popen[bytes], log: Path) -> None:
    """Wait until the server answers, and make the extensions."""
    import psycopg

    deadline = time.monotonic() + 60.0
    while True:
        try:
            connection = psycopg.connect(address, autocommit=True)
            break
        except psycopg.OperationalError as cause:
            if server.poll() is not None or time.monotonic() > deadline:
                said = log.read_text(encoding="utf-8", errors="replace").strip()[-500:]
                raise PostgisUnavailable(f"PostgreSQL did not start: {said}") from cause
            time.sleep(0.05)
    with connection:
        try:
            connection.execute("CREATE EXTENSION postgis")
            connection.execute("CREATE EXTENSION postgis_sfcgal")
        except psycopg.Error as cause:
            raise PostgisUnavailable(f"PostGIS with SFCGAL was not found ({cause}); {REMEDY}") from cause
