"""One vocabulary: the table in Python, the rule files, the sentences and kb/ say the same."""

from __future__ import annotations

import importlib
import re
import subprocess
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from deixis._files import datalog_files
from deixis.ruleset import SHIPPED, load, locate
from deixis.thresholds import Thresholds
from deixis.vocabulary import BASE, RELATIONS, TERMS

# One run of SWI-Prolog for all of these.
pytestmark = pytest.mark.xdist_group("vocabulary")

LAST_AXIOM = 40
LAST_OF_APPENDIX = 57
MOST_LINES = 60
SECTIONS = ["Context", "Decision", "Consequences"]

# Prints a line of tab-separated fields for each thing the rule files say of the vocabulary.
PROBE = r"""
:- set_prolog_flag(encoding, utf8).
:- use_module(library(lists)).
:- use_module(library(readutil)).
:- use_module(library(pldoc)).
:- use_module(library(pldoc/doc_process)).
:- doc_collect(true).

main :-
    current_prolog_flag(argv, [Tests|Files]),
    load_files(Files, [imports([])]),
    forall(( member(Module, [facts, topology, direction, commonsense]),
             module_property(Module, exports(Exports)),
             member(Name/Arity, Exports) ),
           ( once(doc_comment(Module:Name/Arity, _, Summary, _)),
             say([export, Name/Arity, Summary]) )),
    forall(axioms:axiom(Predicate, Number), say([axiom, Predicate, Number])),
    forall(axioms:base(Predicate), say([base, Predicate, ''])),
    forall(axioms:relation(Predicate), say([relation, Predicate, ''])),
    forall(( clause(en:sentence(Goal, _), _), functor(Goal, Name, Arity) ),
           say([sentence, Name/Arity, ''])),
    read_file_to_terms(Tests, Terms, []),
    forall(( member((:- begin_tests(Unit)), Terms), sub_atom(Unit, 0, _, _, axiom_) ),
           say([unit, Unit, ''])).

say([Kind, Predicate, Rest]) :-
    format("~w\t~w\t~w~n", [Kind, Predicate, Rest]).
"""

RULE_FILES = ("facts", "topology", "direction", "commonsense", "axioms", "lang/en")

TABLE = {f"{term.name}/{term.arity}": term for term in TERMS}


@dataclass(frozen=True)
class Said:
    """What the rule files say: rows (predicate, rest) by kind, repetitions included."""

    rows: dict[str, list[tuple[str, str]]]

    def predicates(self, kind: str) -> list[str]:
        return [predicate for predicate, _ in self.rows[kind]]


@pytest.fixture(scope="module")
def said(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Said:
    """Load the rule files in SWI-Prolog, once, and let it say what they hold."""
    probe = tmp_path_factory.mktemp("probe") / "probe.pl"
    probe.write_text(PROBE, encoding="utf-8")
    files = [str(root / "rules" / f"{name}.pl") for name in RULE_FILES]
    tests = root / "tests" / "rules" / "axioms.plt"
    strict = ["--on-error=status", "--on-warning=status"]
    result = subprocess.run(
        ["swipl", "-f", "none", *strict, "-g", "main", "-t", "halt", str(probe), "--", str(tests), *files],
        capture_output=True,
        encoding="utf-8",
        timeout=60,
        check=False,
    )
    assert (result.returncode, result.stderr) == (0, "")
    rows: dict[str, list[tuple[str, str]]] = {
        kind: [] for kind in ("export", "axiom", "base", "relation", "sentence", "unit")
    }
    for line in result.stdout.splitlines():
        kind, predicate, rest = line.split("\t")
        rows[kind].append((predicate, rest))
    return Said(rows)


def test_table_names_each_thing_once() -> None:
    assert len(TABLE) == len(TERMS)
    assert len({term.name for term in TERMS}) == len(TERMS)
    assert len({term.rdf for term in TERMS}) == len(TERMS)
    assert [term.name for term in (*BASE, *RELATIONS) if term.arity != 2 + term.view] == []


def test_rules_export_the_table(said: Said) -> None:
    assert [name for name, count in Counter(said.predicates("export")).items() if count > 1] == []
    assert TABLE.keys() - set(said.predicates("export")) == set()


def test_comments_number_the_predicates_as_the_table_does(said: Said) -> None:
    opening = {name: re.match(r"Axioms? (\d+)", summary) for name, summary in said.rows["export"]}
    numbered = {name: int(number[1]) for name, number in opening.items() if number}
    assert {name: TABLE[name].axiom for name in numbered if name in TABLE} == numbered
    assert [f"{t.name}/{t.arity}" for t in (*BASE, *RELATIONS) if f"{t.name}/{t.arity}" not in numbered] == []


def test_axioms_pl_is_the_table(said: Said) -> None:
    listed = [(name, int(number)) for name, number in said.rows["axiom"]]
    assert sorted(listed) == sorted((name, term.axiom) for name, term in TABLE.items())


@pytest.mark.parametrize("kind", ["base", "relation"])
def test_axioms_pl_sorts_as_the_table(said: Said, kind: str) -> None:
    assert sorted(said.predicates(kind)) == sorted(n for n, term in TABLE.items() if term.kind == kind)


def test_every_term_has_a_sentence_and_every_sentence_a_predicate(said: Said) -> None:
    sentences = set(said.predicates("sentence"))
    assert TABLE.keys() - sentences == set()
    theory = datalog_files()
    shipped = {f"{name}/{arity}" for name, arity in load(theory, locate(SHIPPED, theory)).user}
    assert shipped - sentences == set()
    assert sentences - set(said.predicates("export")) == shipped


def rows(text: str) -> Iterator[list[str]]:
    """Yield the cells of each row of each table of a Markdown text, without the rules under the heads."""
    for line in text.splitlines():
        if line.startswith("|") and not set(line) <= set("|- :"):
            yield [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]


@pytest.fixture(scope="module")
def axioms(root: Path) -> dict[str, list[list[str]]]:
    """Return the table rows of kb/axioms.md by section."""
    parts = re.split(
        r"^## (.+)$", (root / "kb" / "axioms.md").read_text(encoding="utf-8"), flags=re.MULTILINE
    )
    return {title: list(rows(body)) for title, body in zip(parts[1::2], parts[2::2], strict=True)}


def numbered_rows(axioms: dict[str, list[list[str]]]) -> list[list[str]]:
    return [row for title, table in axioms.items() if title != "Names" for row in table if row[0].isdigit()]


def test_axioms_md_has_a_row_for_each_equation(axioms: dict[str, list[list[str]]]) -> None:
    numbers = [int(row[0]) for row in numbered_rows(axioms)]
    assert numbers == list(range(1, LAST_OF_APPENDIX + 1))


def test_axioms_md_gives_each_axiom_its_predicates(axioms: dict[str, list[list[str]]]) -> None:
    found = {
        (int(row[0]), predicate)
        for row in numbered_rows(axioms)[:LAST_AXIOM]
        for predicate in re.findall(r"`(\w+/\d)`", row[2])
    }
    assert found == {(term.axiom, name) for name, term in TABLE.items()}


def test_axioms_md_names_the_units(said: Said, axioms: dict[str, list[list[str]]]) -> None:
    units = said.predicates("unit")
    first = numbered_rows(axioms)[:LAST_AXIOM]
    named = [(row[0], unit) for row in first for unit in re.findall(r"`(axiom_\w+)`", row[4])]
    assert sorted(unit for _, unit in named) == sorted(units)
    assert [(number, unit) for number, unit in named if not unit.startswith(f"axiom_{int(number):02}_")] == []
    assert set(units) <= {f"axiom_{term.axiom:02}_{term.name}" for term in TERMS}
    assert {term.axiom for term in (*BASE, *RELATIONS)} - {int(unit[6:8]) for unit in units} == set()


def test_axioms_md_lists_the_table(axioms: dict[str, list[list[str]]]) -> None:
    assert axioms["Names"][1:] == [
        [term.paper, f"`{name}`", term.kind, "yes" if term.view else "", f"`{term.rdf}`", str(term.axiom)]
        for name, term in TABLE.items()
    ]


def test_conventions_md_gives_the_default_thresholds(root: Path) -> None:
    text = (root / "kb" / "conventions.md").read_text(encoding="utf-8")
    (section,) = re.findall(r"^## Thresholds$(.+?)^## ", text, flags=re.MULTILINE | re.DOTALL)
    head, *table = rows(section)
    name, default = head.index("name"), head.index("default")
    assert [(row[name], float(row[default])) for row in table] == [
        (f"`{threshold}`", value) for threshold, value in Thresholds().items()
    ]


def decisions(root: Path) -> list[Path]:
    return sorted((root / "kb" / "decisions").iterdir())


def test_decisions_are_numbered_without_a_gap(root: Path) -> None:
    names = [path.name for path in decisions(root)]
    assert [name for name in names if not re.fullmatch(r"\d{4}-[a-z0-9-]+\.md", name)] == []
    assert [int(name[:4]) for name in names] == list(range(1, len(names) + 1))


def test_decisions_fit_on_a_page_and_have_its_parts(root: Path) -> None:
    for path in decisions(root):
        lines = path.read_text(encoding="utf-8").splitlines()
        assert len(lines) <= MOST_LINES, path.name
        assert re.fullmatch(rf"# {path.name[:4]} \S.+", lines[0]), path.name
        assert [line[3:] for line in lines if line.startswith("## ")] == SECTIONS, path.name


def documents(root: Path) -> list[Path]:
    return sorted([*root.glob("*.md"), *(root / "kb").rglob("*.md")])


def test_links_into_kb_resolve(root: Path) -> None:
    broken = [
        (path.relative_to(root).as_posix(), link)
        for path in documents(root)
        for link in re.findall(r"\]\(([^)\s#]+)", path.read_text(encoding="utf-8"))
        if "://" not in link
        and (path.is_relative_to(root / "kb") or link.startswith("kb/"))
        and not (path.parent / link).exists()
    ]
    assert broken == []


def test_links_say_the_number_they_lead_to(root: Path) -> None:
    wrong = [
        (path.relative_to(root).as_posix(), number, target)
        for path in documents(root)
        for number, target in re.findall(r"\[(\d{4})\]\(([^)]+)\)", path.read_text(encoding="utf-8"))
        if not Path(target).name.startswith(f"{number}-")
    ]
    assert wrong == []


def test_code_that_the_documents_name_exists(root: Path) -> None:
    modules = {path.stem for path in (root / "src" / "deixis").glob("*.py")}
    named = {
        (path.relative_to(root).as_posix(), module, tuple(rest.split(".")))
        for path in (root / "kb").rglob("*.md")
        for module, rest in re.findall(r"`([a-z_]+)\.(\w+(?:\.\w+)*)`", path.read_text(encoding="utf-8"))
        if module in modules and rest not in ("py", "pl", "json")
    }
    assert named != set()
    assert {place for place in named if not exists(*place[1:])} == set()


def exists(module: str, names: tuple[str, ...]) -> bool:
    """Return whether a module has a thing by this path, the fields of dataclasses included."""
    thing: object = importlib.import_module(f"deixis.{module}")
    for name in names:
        if name in getattr(thing, "__dataclass_fields__", {}):
            return name == names[-1]
        if not hasattr(thing, name):
            return False
        thing = getattr(thing, name)
    return True


def test_decisions_that_the_code_names_exist(root: Path) -> None:
    known = {path.name[:4] for path in decisions(root)}
    files = [
        path for top in ("src", "rules") for path in (root / top).rglob("*") if path.suffix in (".py", ".pl")
    ]
    named = {
        (path.relative_to(root).as_posix(), number)
        for path in files
        for number in re.findall(r"\bdecision (\d{4})\b", path.read_text(encoding="utf-8"))
    }
    assert named != set()
    assert {(path, number) for path, number in named if number not in known} == set()
