"""IRIs of one scene: the scene, its things and views, its graphs and the steps of its proofs.

=================  ==========================================================================
the scene          ``urn:deixis:scene:S``, which also names the graph of what no view changes
a thing            ``urn:deixis:scene:S:thing:ID``
a view             ``urn:deixis:scene:S:view:ID``, which also names the graph of what is seen from it
other graphs       ``urn:deixis:scene:S:metadata``, ``...:derivations``, ``...:history``
=================  ==========================================================================

Ids are percent-encoded, colons too, so that no id can be read as anything else and each comes back exactly.
"""

from __future__ import annotations

from typing import Final
from urllib.parse import quote

from deixis.rdf.layout import ID
from deixis.rdf.namespaces import PREFIXES

SCENE: Final = "urn:deixis:scene:"


class SceneNames:
    """The IRIs of a scene.

    Parameters
    ----------
    scene : str
        The scene's id.
    things, views : tuple of str
        The ids it has; any other name is an IRI of no scene.

    Examples
    --------
    >>> names = SceneNames("flat 2", things=("cup",), views=("v0",))
    >>> names.thing("cup"), names.view("v0")
    ('urn:deixis:scene:flat%202:thing:cup', 'urn:deixis:scene:flat%202:view:v0')
    >>> names.named("red")
    'urn:deixis:id:red'
    """

    def __init__(self, scene: str, things: tuple[str, ...] = (), views: tuple[str, ...] = ()) -> None:
        self.scene = SCENE + quote(scene, safe="")
        self.metadata = f"{self.scene}:metadata"
        self.derivations = f"{self.scene}:derivations"
        self.history = f"{self.scene}:history"
        self.run = f"{self.scene}:run"
        self.thresholds = f"{self.scene}:thresholds"
        self.frame = f"{self.scene}:frame"
        self._things, self._views = frozenset(things), frozenset(views)
        self._known: dict[str, str] = {}

    def thing(self, name: str) -> str:
        """Return the IRI of a thing."""
        found = self._known.get(name)
        if found is None:
            found = self._known[name] = f"{self.scene}:thing:{quote(name, safe='')}"
        return found

    def view(self, name: str) -> str:
        """Return the IRI of a view, and of the graph of what holds in it."""
        return f"{self.scene}:view:{quote(name, safe='')}"

    def prefixes(self) -> dict[str, str]:
        """Return prefixes for Turtle and for queries: the vocabularies', and this scene's own."""
        parts = {"thing": "thing:", "view": "view:", "derived": "derivations:", "scene": ""}
        return PREFIXES | {prefix: f"{self.scene}:{part}" for prefix, part in parts.items()}

    def named(self, name: str) -> str:
        """Return the IRI of any name: of the thing or else the view of that id, or of a mere name."""
        if name in self._things:
            return self.thing(name)
        return self.view(name) if name in self._views else ID + quote(name, safe="")

    def is_view(self, name: str) -> bool:
        """Return whether a name is a view's."""
        return name in self._views

    def row(self, relation: str, *args: str) -> str:
        """Return the IRI of a row with more than two arguments."""
        return ":".join([self.scene, "row", quote(relation, safe=""), *(quote(one, safe="") for one in args)])

    def holding(self, since: float, relation: str, *args: str) -> str:
        """Return the IRI of a relation of some names while it held, by when that began."""
        parts = (repr(float(since)), relation, *args)
        return ":".join([self.history, *(quote(one, safe="") for one in parts)])

    def instant(self, stamp: float) -> str:
        """Return the IRI of a moment, by its seconds since the epoch."""
        return f"{self.scene}:instant:{quote(repr(float(stamp)), safe='')}"

    def derivation(self, relation: str, *args: str) -> str:
        """Return the IRI of what derives a relation of some names."""
        return ":".join([self.derivations, quote(relation, safe=""), *(quote(one, safe="") for one in args)])
