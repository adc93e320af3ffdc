"""One pure function on record batches: scenes in, their relations and what was refused out.

It keeps nothing but compiled rules, so whatever schedules batches (processes, Ray, Spark) may call it
anywhere, any number of times.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import pyarrow as pa

from deixis import readers
from deixis._files import datalog_files
from deixis.batch.columns import Columns
from deixis.batch.schema import ERRORS, SCENES
from deixis.engines import AutoExecutor, predicates
from deixis.errors import DeixisError, ReaderError, SceneError
from deixis.facts import RegionModel
from deixis.grounding import ground
from deixis.inference import Inference
from deixis.ruleset import Indicator, Ruleset, load, locate
from deixis.scene import Scene
from deixis.strict_json import parse, quoted
from deixis.vocabulary import asked_for

_SAMPLE: Final[dict[str, Any]] = {
    "deixis": 1,
    "id": "sample",
    "objects": [
        {"id": "floor", "kind": "surface", "box": {"center": [0, 0, -0.05], "size": [4, 4, 0.1]}},
        {
            "id": "wedge",
            "mesh": {
                "vertices": [[0, 0, 0], [0, 0, 0.5], [0, 0.4, 0], [0.4, 0, 0]],
                "faces": [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]],
            },
        },
    ],
    "views": [{"id": "v", "position": [1, -3, 1]}],
}
"""A scene of a moment, with all that has to be imported."""


@dataclass(frozen=True)
class Relate:
    """Derives the relations of a batch of scenes; can be pickled, and called anywhere any number of times.

    Parameters
    ----------
    relations : str or tuple of str
        Which; by default all that people speak in.
    rules : tuple of str
        Rule files of one's own, or names of shipped ones.
    region : "box", "hull" or "mesh"
        What things are measured as.
    view : str, optional
        Only this view's horizontal relations; a scene without it is refused.

    Examples
    --------
    >>> from deixis._files import kb_dir
    >>> text = (kb_dir() / "scenes" / "hans.json").read_bytes()
    >>> scenes = {"source": ["hans", "odd"], "scene": [text, b"{"], "file": [None, None]}
    >>> batch = pa.RecordBatch.from_pydict(scenes, schema=SCENES)
    >>> relations, errors = Relate(relations=("leans_on",))(batch)
    >>> relations.column("figure").to_pylist(), errors.column("source").to_pylist()
    (['extinguisher2'], ['odd'])
    """

    relations: str | tuple[str, ...] = ()
    rules: tuple[str, ...] = ()
    region: RegionModel = "box"
    view: str | None = None

    def __call__(
        self, batch: pa.RecordBatch, around: Callable[[], AbstractContextManager[object]] = nullcontext
    ) -> tuple[pa.RecordBatch, pa.RecordBatch]:
        """Return the relations of the scenes of a batch, and what was refused with the reason.

        Parameters
        ----------
        batch : RecordBatch
            With the schema :data:`~deixis.batch.schema.SCENES`.
        around : callable
            Returns a context that each scene is looked at in, such as one that ends it.

        Returns
        -------
        relations : RecordBatch
            With the schema :data:`~deixis.batch.schema.RELATIONS`: by scene as they come, then in the order
            of the vocabulary, then by figure, reference and view.
        errors : RecordBatch
            With the schema :data:`~deixis.batch.schema.ERRORS`.

        Raises
        ------
        RuleError
            Something is wrong with a rule file: no scene can be looked at.
        QueryError
            There is no such relation.
        """
        columns = Columns(self._places)
        errors: list[tuple[str, str, str]] = []
        given = [batch.column(name).to_pylist() for name in SCENES.names]
        for source, text, file in zip(*given, strict=True):
            try:
                with around():
                    found = [self._found(scene) for scene in _scenes(text, file)]
            except DeixisError as error:
                errors.append((source, type(error).__name__, str(error)))
            except Exception as error:  # noqa: BLE001 - one scene must not stop a million: told in full, as its own row
                errors.append((source, type(error).__name__, _told(error)))
            else:
                for scene, tables in found:
                    labels = {thing.id: thing.label or None for thing in scene.objects}
                    noise = scene.thresholds.pose_noise
                    columns.add(source, scene.id, tables, labels, noise, self.view)
        return columns.batch(), refusals(errors)

    def ready(self) -> None:
        """Compile the rules and look at a small scene, so that the first takes no longer than others.

        Raises
        ------
        RuleError, QueryError, MissingDependency
            Something is wrong with a rule file, there is no such relation, or meshes cannot be measured.
        """
        scene = Scene.from_dict(_SAMPLE)
        tables = self._derived(scene)
        Columns(self._places).add("", scene.id, tables, {}, 0.0, None)

    def __getstate__(self) -> dict[str, Any]:
        return asdict(self)  # what is compiled is compiled again wherever it goes

    @cached_property
    def _ruleset(self) -> Ruleset:
        return load(datalog_files(), self.rule_files)

    @cached_property
    def rule_files(self) -> tuple[Path, ...]:
        """Return the rule files of one's own, each after those it imports."""
        return locate(self.rules, datalog_files()) if self.rules else ()

    @cached_property
    def _executor(self) -> AutoExecutor:
        return AutoExecutor(self._ruleset)

    @cached_property
    def _places(self) -> dict[Indicator, str]:
        """Return the predicates to derive, each with where it is stated."""
        names = asked_for(self.relations or None)
        own = self._ruleset if self.rules else None
        found = [one for name in names for one in predicates(name, own)]
        stated = {one: self._ruleset.by_head[one][0].place for one in found}
        return {one: f"{place.file.name}:{place.line}" for one, place in stated.items()}

    def _found(self, scene: Scene) -> tuple[Scene, Any]:
        if self.view is not None:
            Inference(scene).check_view(self.view)
        return scene, self._derived(scene)

    def _derived(self, scene: Scene) -> Any:
        facts = ground(scene, region=self.region)
        labels = [(view.id, view.label) for view in scene.views]
        return self._executor.run(facts, list(self._places), view_labels=labels)


def refusals(rows: Iterable[tuple[str, str, str]]) -> pa.RecordBatch:
    """Return source, kind and reason of what was refused as a batch."""
    # Arrow takes no halves of characters, which messages may quote.
    plain = [[text.encode("utf-8", "replace").decode() for text in row] for row in rows]
    columns = list(zip(*plain, strict=True)) or [()] * len(ERRORS)
    return pa.RecordBatch.from_arrays([pa.array(one, pa.string()) for one in columns], schema=ERRORS)


def _scenes(text: bytes | None, file: str | None) -> tuple[Scene, ...]:
    """Return the scene of a text, or those of a file of any format that a reader knows."""
    if text is not None:
        base = None if file is None else Path(file).parent
        return (Scene.from_dict(parse(text, SceneError, "the scene"), base),)
    if file is None:
        raise ReaderError("neither a scene nor a file is given: give one")
    name = readers.sniff(file)
    if name is None:
        known = ", ".join(readers.formats())
        raise ReaderError(f"{quoted(Path(file).name, 200)} is of no format that a reader knows: {known}")
    return readers.read(name, file)


def _told(error: Exception) -> str:
    """Return what went wrong that nobody foresaw, and where."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{str(error) or 'no more is known'} ({Path(last.filename).name}:{last.lineno}): report the scene"
