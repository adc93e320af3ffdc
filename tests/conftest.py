"""What all tests share: where the repository is, and how hard hypothesis searches."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from cluster import cluster  # noqa: F401 - a fixture
from deixis._files import theory_files
from deixis.knowledge import KnowledgeBase
from deixis.prolog import PrologEngine
from deixis.scene import Scene
from deixis.vocabulary import BASE, RELATIONS

# One commit, one verdict: derandomised, so that what failed on one machine fails on the next.
settings.register_profile("quick", max_examples=50, derandomize=True, deadline=None, database=None)
settings.register_profile("long", max_examples=2000, deadline=None, print_blob=True)
settings.load_profile("quick")

SLOW = {
    f"test_{name}.py"
    for name in [
        "batch",
        "batch_ray",
        "campaign",
        "catalogue",
        "endpoint_living",
        "endpoint_safety",
        "endpoint_store",
        "executors",
        "history",
        "notebooks",
        "oracles",
        "page_follows",
        "perception",
        "postgis",
        "prepositions",
        "readme",
        "regions",
        "tiles",
        "view_page",
    ]
}
"""Files that take long: begun first, so that no processor is left alone with one at the end."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: item.path.name not in SLOW)


@pytest.fixture(scope="session")
def root() -> Path:
    """Return the top of the checkout."""
    return Path(__file__).resolve().parent.parent


@pytest.fixture(scope="session")
def figure_3(root: Path) -> Scene:
    """Return the paper's Figure 3."""
    return Scene.load(root / "kb" / "scenes" / "hans.json")


@pytest.fixture(scope="session")
def engine() -> Iterator[PrologEngine]:
    """Return one SWI-Prolog with the theory loaded, shared by the tests of a worker."""
    with PrologEngine(theory_files()) as running:
        yield running


@pytest.fixture(scope="session")
def reason(engine: PrologEngine) -> Callable[..., set[tuple[str, ...]]]:
    """Return a function from a scene, and more base relations' names, to all rows that hold by the rules."""

    def rows(scene: Scene, *base: str) -> set[tuple[str, ...]]:
        engine.load(KnowledgeBase(scene).facts_text(readable=False))
        terms = [*RELATIONS, *(term for term in BASE if term.name in base)]
        found = engine.relations([(term.name, term.arity) for term in terms])
        return {(name, *row) for name, answers in found.items() for row in answers}

    return rows
