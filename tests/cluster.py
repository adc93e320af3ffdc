"""A Ray cluster on this machine, for the tests of a module: the fixture `cluster`."""

from __future__ import annotations

import os
import secrets
import tempfile
from collections.abc import Iterator
from unittest.mock import patch

import pytest

MARK = "DEIXIS_TEST_CLUSTER"


TOKEN = secrets.token_hex(16)
"""What a cluster is spoken to with; Ray reads it once in a process."""


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """Start two workers that only this process may use; return what their environment is known by."""
    # Not at the top: it takes seconds, and all tests know this fixture.
    import ray

    private = {MARK: TOKEN, "RAY_USAGE_STATS_ENABLED": "0", "RAY_AUTH_TOKEN": TOKEN}
    # Not below pytest's folder: the path of a socket must be short.
    with patch.dict(os.environ, private), tempfile.TemporaryDirectory(prefix="ray") as folder:
        ray.init(
            num_cpus=2,
            object_store_memory=80 << 20,
            include_dashboard=False,
            log_to_driver=False,
            logging_level="error",
            _node_ip_address="127.0.0.1",
            _temp_dir=folder,
        )
        yield TOKEN
        ray.shutdown()
