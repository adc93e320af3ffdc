"""Telling: a relation as a plain sentence, fast enough for thousands of moments.

The reasons are SWI-Prolog's to tell; what holds is said in the same words, which a test compares.
"""

from __future__ import annotations

from collections import Counter
from typing import Final

from deixis.relations import Relation
from deixis.scene import Scene
from deixis.wording import as_sentence
from deixis.words.phrases import perspective

VERBS: Final = {
    "above": "is above",
    "below": "is below",
    "right_of": "is right of",
    "left_of": "is left of",
    "in_front_of": "is in front of",
    "behind": "is behind",
    "beside": "is beside",
    "on_top_of": "is on top of",
    "leans_on": "leans on",
    "affixed_on": "is affixed on",
    "part_in": "is partly in",
    "inside": "is inside",
    "near": "is near",
}
"""What is said of the relations of the theory; one's own are said by their names."""


class Teller:
    """Says what holds in a scene.

    Parameters
    ----------
    scene : Scene

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> teller = Teller(Scene.load(kb_dir() / "scenes" / "hans.json"))
    >>> teller(Relation("on_top_of", "sweater", "heater", None, 0.02))
    'The sweater is on top of the electric heater.'
    """

    def __init__(self, scene: Scene) -> None:
        labels = Counter(thing.label for thing in scene.objects)
        self._names = {
            thing.id: thing.id
            if not thing.label
            else f"the {thing.label}"
            if labels[thing.label] == 1
            else f"the {thing.label} ({thing.id})"
            for thing in scene.objects
        }
        self._views = {view.id: perspective(view.label or view.id) for view in scene.views}

    def __call__(self, one: Relation) -> str:
        """Return the sentence of a relation."""
        verb = VERBS.get(one.relation) or one.relation.replace("_", " ")
        figure, reference = (self._names.get(name, name) for name in (one.figure, one.reference))
        seen = "" if one.view is None else f" {self._views.get(one.view, one.view)}"
        return as_sentence(f"{figure} {verb} {reference}{seen}")
