"""The first child of the server: from it, ready in milliseconds, come those that load, query and reason.

python -m deixis.server.root DESCRIPTOR
"""

from __future__ import annotations

import socket
import sys
from collections.abc import Mapping
from typing import Any

from deixis.rdf.evaluator import Evaluator
from deixis.server.forks import Reply, attend
from deixis.server.reasons import Reasons
from deixis.server.wire import Channel


class Work:
    """What a child can be asked: of a dataset, and of a scene."""

    def __init__(self) -> None:
        self._evaluator, self._reasons = Evaluator(), Reasons()

    def load(self, header: Mapping[str, Any], body: bytes) -> Reply:
        """Take in a dataset."""
        split = header["split"]
        return {"quads": self._evaluator.load(body[:split], body[split:], header["owned"])}, b""

    def query(self, header: Mapping[str, Any], body: bytes) -> Reply:
        """Answer a query."""
        return self._evaluator.query(body.decode(), **header["with"])

    def graph(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Return a graph."""
        if header["all"]:
            return {}, self._evaluator.everything(header["form"], header["size"])
        found = self._evaluator.graph(header["name"], header["form"], header["size"])
        return {"missing": found is None}, found or b""

    def names(self, _header: Mapping[str, Any], _body: bytes) -> Reply:
        """Return the names of the graphs."""
        return {"names": self._evaluator.names()}, b""

    def update(self, header: Mapping[str, Any], body: bytes) -> Reply:
        """Carry out an update."""
        return {}, self._evaluator.update(body.decode(), header["base"])

    def put(self, header: Mapping[str, Any], body: bytes) -> Reply:
        """Write a graph."""
        parts, at = [], 0
        for form, size in header["parts"]:
            parts.append((form, body[at : at + size]))
            at += size
        replace, base = header["replace"], header["base"]
        return {}, self._evaluator.put(header["name"], parts, replace=replace, base=base)

    def drop(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Remove a graph."""
        return {}, self._evaluator.drop(header["name"])

    def scene(self, header: Mapping[str, Any], body: bytes) -> Reply:
        """Take in a scene."""
        return self._reasons.load(body, export=header["export"])

    def tell(self, header: Mapping[str, Any], body: bytes) -> Reply:
        """Take in an update of the scene."""
        return self._reasons.tell(body, **header["with"])

    def objects(self, _header: Mapping[str, Any], _body: bytes) -> Reply:
        """Return the things of the scene."""
        return self._reasons.objects(), b""

    def relations(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Return relations of the scene."""
        return self._reasons.relations(**header["with"]), b""

    def ask(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Answer a goal."""
        return self._reasons.ask(**header["with"]), b""

    def called(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Say what things are called."""
        return self._reasons.called(**header["with"]), b""

    def why(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Explain a relation."""
        return self._reasons.why(**header["with"]), b""

    def why_all(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Explain a relation in all ways."""
        return self._reasons.why_all(**header["with"]), b""

    def why_not(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Explain why a relation does not hold."""
        return self._reasons.why_not(**header["with"]), b""

    def contrast(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Explain one relation beside another."""
        return self._reasons.contrast(**header["with"]), b""

    def change(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Find what would change a relation."""
        return self._reasons.change(**header["with"]), b""

    def what_if(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Find what would be otherwise."""
        return self._reasons.what_if(**header["with"]), b""

    def view(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Show the scene."""
        return {}, self._reasons.page(**header["with"])

    def shown(self, header: Mapping[str, Any], _: bytes) -> Reply:
        """Return the data of the page, for one that is open."""
        return {}, self._reasons.shown(**header["with"])


def _prepare() -> None:
    """Do once what every child would do first: what is imported and read by then is theirs too."""
    reasons = Reasons()
    reasons.load(b'{"deixis": 1, "id": "none", "objects": [], "views": []}', export=False)
    reasons.tell(b'{"objects": [{"id": "a", "box": {"center": [0, 0, 0], "size": [1, 1, 1]}}]}', most=0)


def main(descriptor: int) -> None:
    """Run as the first child."""
    _prepare()
    work = Work()
    names = [name for name in vars(Work) if not name.startswith("_")]
    attend(Channel(socket.socket(fileno=descriptor)), {name: getattr(work, name) for name in names})


if __name__ == "__main__":
    main(int(sys.argv[1]))
