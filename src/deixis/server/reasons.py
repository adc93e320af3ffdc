"""One scene's knowledge base, for a process of its own: what the JSON interface asks."""

from __future__ import annotations

import base64
import json
from typing import Any, Final

from deixis.errors import QueryError, SceneError
from deixis.knowledge import KnowledgeBase
from deixis.relations import Relation
from deixis.scene import Scene
from deixis.server.goals import answers
from deixis.strict_json import MAX_FILE_BYTES, parse

_EXPORTED: Final = "the scene"


class Reasons:
    """A scene, and what follows from it.

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> reasons = Reasons()
    >>> told, _ = reasons.load((kb_dir() / "scenes" / "hans.json").read_bytes(), export=False)
    >>> told["id"], reasons.relations(relation=["leans_on"])["relations"][0]["figure"]
    ('hans', 'extinguisher2')
    """

    def __init__(self) -> None:
        self._kb: KnowledgeBase | None = None
        self._explaining: KnowledgeBase | None = None
        self._known: dict[tuple[str, ...] | None, tuple[Relation, ...]] = {}
        self._shown: tuple[str, str] | None = None

    @property
    def kb(self) -> KnowledgeBase:
        """Return the knowledge base."""
        if self._kb is None:
            raise QueryError("no scene is loaded")
        return self._kb

    @property
    def explaining(self) -> KnowledgeBase:
        """Return the knowledge base with the rules of safety, whose breaches have reasons too."""
        if self._explaining is None:
            self._explaining = KnowledgeBase(self.kb.scene, rules=("safety",))
            self._explaining.facts = self.kb.facts
        return self._explaining

    def load(self, text: bytes, *, export: bool) -> tuple[dict[str, Any], bytes]:
        """Take in a scene in JSON; return what it holds and, if wanted, all its quads.

        Raises
        ------
        SceneError
            It is not well formed, or names files: what is sent brings its geometry along.
        """
        scene = Scene.from_dict(parse(text, SceneError, _EXPORTED))
        self._kb, self._explaining = KnowledgeBase(scene), None
        self._known, self._shown = {}, None
        if not export:
            return self._summary(), b""
        from deixis.rdf.export import graph_names, nquads

        quads = nquads(self._kb)
        return {**self._summary(), "graphs": graph_names(self._kb), "text": scene.to_json()}, quads

    def tell(self, text: bytes, *, most: int) -> tuple[dict[str, Any], bytes]:
        """Take in an update in JSON; return what the scene holds, and its text with what changed after it.

        Parameters
        ----------
        text : bytes
            See :meth:`deixis.updates.Update.from_dict`.
        most : int
            Bytes of what changed; where it is more, only how many relations did.

        Raises
        ------
        SceneError
            The update is not well formed, or tells of what is not there; the scene is as it was.
        TooLarge
            The scene is larger than any that is read; it has changed here, and is not to be served.
        """
        from deixis.rdf.evaluator import TooLarge
        from deixis.rdf.export import graph_names
        from deixis.updates import Update

        update = Update.from_dict(parse(text, SceneError, "the update"), self.kb.scene)
        found = self.kb.update(update)
        changes = json.dumps(found.to_dict(), ensure_ascii=False, allow_nan=False).encode()
        count = len(found.gained) + len(found.lost)
        if len(changes) > most:
            changes = b""
        whole = self.kb.scene.to_json().encode()
        if len(whole) > MAX_FILE_BYTES:
            raise TooLarge(f"the scene would have {len(whole):,} bytes: the limit is {MAX_FILE_BYTES:,}")
        names = graph_names(self.kb)
        return {**self._summary(), "graphs": names, "split": len(whole), "count": count}, whole + changes

    def _summary(self) -> dict[str, Any]:
        scene = self.kb.scene
        return {
            "id": scene.id,
            "objects": len(scene.objects),
            "views": [{"id": view.id, "label": view.label} for view in scene.views],
            "notes": list(scene.diagnostics),
        }

    def objects(self) -> dict[str, Any]:
        """Return the things of the scene with their labels and boxes."""
        boxes = self.kb.scene.boxes
        rows = zip(self.kb.scene.objects, boxes.center, boxes.half, boxes.yaw, strict=True)
        return {
            "objects": [
                {
                    "id": thing.id,
                    "kind": thing.kind,
                    "labels": [{"name": label.name, "score": label.score} for label in thing.labels],
                    "box": {"center": center.tolist(), "size": (2.0 * half).tolist(), "yaw": float(yaw)},
                }
                for thing, center, half, yaw in rows
            ]
        }

    def relations(
        self,
        *,
        relation: list[str] | None = None,
        figure: str | None = None,
        reference: str | None = None,
        view: str | None = None,
        label: str | None = None,
        margin: float | None = None,
        limit: int = 1000,
        cursor: str | None = None,
    ) -> dict[str, Any]:
        """Return the relations that pass all filters, a page of them.

        ``label`` is one of the figure or the reference; ``margin`` the least.
        """
        key = None if relation is None else tuple(sorted(set(relation)))
        if view is not None:
            self.kb.check_view(view)
        for name in (figure, reference):
            if name is not None:
                self.kb.scene.index(name)
        if key not in self._known:
            if len(self._known) > 100:
                self._known.clear()
            self._known[key] = self.kb.relations(relation=relation)
        labels = {
            thing.id for thing in self.kb.scene.objects if any(one.name == label for one in thing.labels)
        }
        found = [
            one
            for one in self._known[key]
            if (figure is None or one.figure == figure)
            and (reference is None or one.reference == reference)
            and (view is None or one.view in (None, view))
            and (label is None or one.figure in labels or one.reference in labels)
            and (margin is None or one.margin is None or one.margin >= margin)
        ]
        start = _position(cursor)
        page = found[start : start + limit]
        more = start + limit < len(found)
        return {
            "relations": [one.to_dict() for one in page],
            "total": len(found),
            "next": _cursor(start + limit) if more else None,
            "withheld": [one.to_dict() for one in self.kb.withheld],
        }

    def ask(self, *, goal: str, limit: int, timeout: float) -> dict[str, Any]:
        """Return the bindings for which a goal of the rules' subset holds, on DuckDB."""
        return answers(self.kb, goal, limit, timeout)

    def called(self, *, view: str | None, timeout: float) -> dict[str, Any]:
        """Return what each thing is called."""
        return {"names": self.explaining.names(view=view, timeout=timeout)}

    def page(self, *, event: str, timeout: float) -> bytes:
        """Return the page that shows the scene, and follows what happens to it after an event."""
        from deixis.view import page_text

        now, later = self._data(event, timeout)
        return page_text(f"{self.kb.scene.id}: Deixis", now, later, follows=True).encode()

    def shown(self, *, event: str, timeout: float) -> bytes:
        """Return the data of the page, for one that is open already."""
        now, later = self._data(event, timeout)
        return f'{{"now":{now},"later":{later}}}'.encode()

    def _data(self, event: str, timeout: float) -> tuple[str, str]:
        """Return the data of the page; made once."""
        from deixis.view import packed

        if self._shown is None:
            now, later = self.kb.page_data(timeout=timeout)
            self._shown = packed({**now, "event": event}), packed(later)
        return self._shown

    def why(self, *, goal: str, timeout: float) -> dict[str, Any]:
        """Return the proof of a relation with its evidence, or how far it is from holding."""
        answer = self.explaining.evidence(self.explaining.why(goal, timeout=timeout))
        return {"goal": goal, **answer.to_dict()}

    def why_all(self, *, goal: str, limit: int, timeout: float) -> dict[str, Any]:
        """Return all proofs of a relation, or the first of them."""
        kb = self.explaining
        return {"goal": goal, **kb.evidence(kb.why_all(goal, limit=limit, timeout=timeout)).to_dict()}

    def why_not(self, *, goal: str, timeout: float) -> dict[str, Any]:
        """Return what keeps each rule from concluding a relation."""
        found = self.explaining.evidence(self.explaining.why_not(goal, timeout=timeout))
        return {"goal": goal, "sentence": found.sentence(), **found.to_dict()}

    def contrast(self, *, goal: str, rather_than: str, timeout: float) -> dict[str, Any]:
        """Return why one relation holds rather than another."""
        kb = self.explaining
        found = kb.evidence(kb.contrast(goal, rather_than, timeout=timeout))
        return {"goal": goal, "rather_than": rather_than, "sentence": found.sentence(), **found.to_dict()}

    def change(self, *, goal: str) -> dict[str, Any]:
        """Return the smallest move that makes a relation hold, or cease to."""
        found = self.kb.change(goal)
        return {"goal": goal, "change": None if found is None else found.to_dict()}

    def what_if(self, *, moves: dict[str, list[float]], limit: int, timeout: float) -> dict[str, Any]:
        """Return what would be otherwise if things stood elsewhere."""
        return self.kb.consequences(moves, limit=limit, timeout=timeout).to_dict()


def _cursor(position: int) -> str:
    return base64.urlsafe_b64encode(json.dumps({"from": position}).encode()).decode()


def _position(cursor: str | None) -> int:
    if cursor is None:
        return 0
    try:
        position = json.loads(base64.urlsafe_b64decode(cursor))["from"]
    except (ValueError, KeyError, TypeError, RecursionError):
        position = None
    if not isinstance(position, int) or isinstance(position, bool) or position < 0:
        raise QueryError("this cursor is none of this server's: take it from `next` of the page before")
    return position
