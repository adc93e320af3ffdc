"""SPARQL on one dataset in memory, for a process that may be killed at any moment.

Whoever asks has looked at the text before: how long and how deep it is, and that it names no service.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from typing import Any, Final

from deixis.errors import QueryError
from deixis.rdf.complaints import complaint
from deixis.rdf.functions import Functions
from deixis.rdf.oxigraph import ox

RESULTS: Final = {
    "json": ox.QueryResultsFormat.JSON,
    "xml": ox.QueryResultsFormat.XML,
    "csv": ox.QueryResultsFormat.CSV,
    "tsv": ox.QueryResultsFormat.TSV,
}
"""How tables and truth values are written."""

GRAPHS: Final = {
    "ttl": ox.RdfFormat.TURTLE,
    "nt": ox.RdfFormat.N_TRIPLES,
    "rdf": ox.RdfFormat.RDF_XML,
    "trig": ox.RdfFormat.TRIG,
    "nq": ox.RdfFormat.N_QUADS,
    "jsonld": ox.RdfFormat.JSON_LD,
}
"""How graphs are written and read."""

_NOTE: Final = "truncated: only the first {} are here; the limit of this server is reached"


class TooLarge(QueryError):
    """The answer has more bytes than may be sent."""


class Refused(QueryError):
    """An update would change what follows from a scene."""


class _Bounded(io.BytesIO):
    """A file in memory that takes no more than so many bytes."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self._most = most

    def write(self, data: Any) -> int:
        if self.tell() + len(data) > self._most:
            raise TooLarge(f"the answer is larger than {self._most} bytes: ask for less, or add a LIMIT")
        return super().write(data)


class Evaluator:
    """A dataset, and what is asked of it.

    Examples
    --------
    >>> evaluator = Evaluator()
    >>> evaluator.load(b"<urn:a> <urn:b> <urn:c> <urn:g> .")
    1
    >>> evaluator.query("ASK { GRAPH ?g { ?s ?p ?o } }", "json", rows=10)[1]
    b'{"head":{},"boolean":true}'
    """

    def __init__(self) -> None:
        self._store = ox.Store()
        self._owned: frozenset[str] = frozenset()
        self._functions = Functions(self._store)

    def load(self, quads: bytes, own: bytes = b"", owned: Sequence[str] = ()) -> int:
        """Take in the quads of all scenes, then those that clients wrote; return how many there are.

        Parameters
        ----------
        quads, own : bytes
            N-Quads.
        owned : sequence of str
            IRIs of the scenes' graphs.
        """
        self._store.bulk_load(quads, format=ox.RdfFormat.N_QUADS)
        self._owned = frozenset(owned)
        if own:
            self._store.bulk_load(own, format=ox.RdfFormat.N_QUADS)
        for name in owned:
            self._store.add_graph(ox.NamedNode(name))
        return len(self._store)

    def query(
        self,
        text: str,
        table: str,
        *,
        graph: str = "ttl",
        rows: int,
        more: str | None = None,
        written: str | None = None,
        size: int = 1 << 26,
        default: Sequence[str] = (),
        named: Sequence[str] = (),
        base: str | None = None,
        union: bool = True,
    ) -> tuple[dict[str, Any], bytes]:
        """Return what there is to say of an answer, and the answer.

        Parameters
        ----------
        text : str
        table, graph : str
            In which format a table or truth value, or a graph, is written: keys of ``RESULTS``, ``GRAPHS``.
        rows : int
            The most rows or triples of an answer.
        more : str, optional
            The same query asking for one row more than that, where the text was cut to give no more.
        written : str, optional
            The query as its author wrote it, if that is not the text: what is wrong is said of it.
        size : int
            The most bytes of an answer.
        default, named : sequence of str
            The dataset by the protocol; the whole one where both are empty.
        base : str, optional
            What relative IRIs are relative to.
        union : bool
            Whether the default graph is all graphs together: not where the text chooses its graphs.

        Raises
        ------
        QueryError
            The query is not well formed, or cannot be answered in this format.
        """

        def run(query: str) -> Any:
            try:
                return self._store.query(query, **options)
            except SyntaxError as error:
                told = complaint(error, query)
                if written is not None:
                    try:
                        self._store.query(written, **options)
                    except SyntaxError as own:
                        told = complaint(own, written)
                raise QueryError(f"the query is not well formed: {told}") from None
            except RuntimeError as error:
                raise QueryError(f"the query cannot be answered: {error}") from None

        options: dict[str, Any] = {"base_iri": base, "custom_functions": self._functions.by_name}
        if default or named:
            options["default_graph"] = [_node(one) for one in default]
            options["named_graphs"] = [_node(one) for one in named]
        else:
            options["use_default_graph_as_union"] = union
        found = run(more or text)
        if isinstance(found, ox.QueryTriples):
            return self._graph(found, graph, rows, size)
        if isinstance(found, ox.QueryBoolean):
            return {"format": table}, found.serialize(format=RESULTS[table]) or b""
        answer = _written(found, table, size)
        if more is None or len(answer) < rows or _rows(answer, table) <= rows:
            return {"format": table}, answer
        answer = _written(run(text), table, size)
        return {"format": table, "truncated": rows}, _noted(answer, table, rows)

    def _graph(self, found: Any, form: str, rows: int, size: int) -> tuple[dict[str, Any], bytes]:
        triples: list[Any] = []
        for triple in found:
            if len(triples) == rows:
                return {"format": form, "truncated": rows}, _noted_graph(
                    _dumped(triples, form, size), form, rows
                )
            triples.append(triple)
        return {"format": form}, _dumped(triples, form, size)

    def graph(self, name: str | None, form: str, size: int) -> bytes | None:
        """Return a graph, the default one without a name; None where there is no such graph."""
        graph = ox.DefaultGraph() if name is None else _node(name)
        if name is not None and not self._store.contains_named_graph(graph):
            return None
        out = _Bounded(size)
        self._store.dump(out, format=GRAPHS[form], from_graph=graph)
        return out.getvalue()

    def everything(self, form: str, size: int) -> bytes:
        """Return the whole dataset."""
        out = _Bounded(size)
        self._store.dump(out, format=GRAPHS[form])
        return out.getvalue()

    def names(self) -> list[str]:
        """Return the IRIs of the named graphs, sorted."""
        return sorted(one.value for one in self._store.named_graphs() if isinstance(one, ox.NamedNode))

    def update(self, text: str, base: str | None = None) -> bytes:
        """Change the dataset, and return all that is not a scene's, as N-Quads.

        Raises
        ------
        QueryError
            The update is not well formed, or failed.
        Refused
            It would change what follows from a scene.
        """
        fixed = self._scene_quads()
        try:
            self._store.update(text, base_iri=base)
        except SyntaxError as error:
            raise QueryError(f"the update is not well formed: {complaint(error, text)}") from None
        except (OSError, RuntimeError, ValueError) as error:
            raise QueryError(f"the update failed: {error}") from None
        return self._own(fixed)

    def put(self, name: str | None, parts: Sequence[tuple[str, bytes]], *, replace: bool, base: str) -> bytes:
        """Write a graph, of parts by their formats; return all that is not a scene's, as N-Quads.

        Raises
        ------
        QueryError
            A part is not well formed, or names graphs of its own.
        Refused
            It would change what follows from a scene.
        """
        fixed = self._scene_quads()
        graph = ox.DefaultGraph() if name is None else _node(name)
        try:
            # The same label in two texts means two nodes.
            quads = [
                quad
                for form, data in parts
                for quad in ox.parse(data, format=GRAPHS[form], base_iri=base, rename_blank_nodes=True)
            ]
        except (SyntaxError, ValueError) as error:
            raise QueryError(f"the graph is not well formed: {_told(error)}") from None
        if any(not isinstance(quad.graph_name, ox.DefaultGraph) for quad in quads):
            raise QueryError("a graph was asked for, and this names graphs of its own: send Turtle")
        if replace:
            self._store.clear_graph(graph)
        if name is not None:
            self._store.add_graph(graph)
        self._store.extend([ox.Quad(q.subject, q.predicate, q.object, graph) for q in quads])
        return self._own(fixed)

    def drop(self, name: str | None) -> bytes:
        """Remove a graph, and return all that is not a scene's, as N-Quads; see :meth:`update`."""
        fixed = self._scene_quads()
        if name is None:
            self._store.clear_graph(ox.DefaultGraph())
        else:
            self._store.remove_graph(_node(name))
        return self._own(fixed)

    def _scene_quads(self) -> set[Any]:
        return {q for one in self._owned for q in self._store.quads_for_pattern(None, None, None, _node(one))}

    def _own(self, fixed: set[Any]) -> bytes:
        if fixed != self._scene_quads():
            raise Refused(
                "this graph follows from a scene and is not written to: PUT the scene at /scenes/ID instead"
            )
        own = [q for q in self._store if q not in fixed]
        return ox.serialize(own, format=ox.RdfFormat.N_QUADS) or b""


def _node(name: str) -> Any:
    try:
        return ox.NamedNode(name)
    except ValueError:
        raise QueryError(f"{name[:200]!r} is no absolute IRI") from None


def _told(error: Exception) -> str:
    """Return what a parser says, without the alphabets it would have liked."""
    return " ".join(str(error.args[0] if error.args else error).split())[:300]


def _written(found: Any, form: str, size: int) -> bytes:
    out = _Bounded(size)
    try:
        found.serialize(output=out, format=RESULTS[form])
    except RuntimeError as error:
        raise QueryError(f"the query cannot be answered: {error}") from None
    return out.getvalue()


def _rows(answer: bytes, form: str) -> int:
    """Return how many rows a written table has."""
    match form:
        case "json":
            return len(json.loads(answer)["results"]["bindings"])
        case "xml":
            return answer.count(b"<result>")
        case "csv":
            return sum(1 for _ in csv.reader(io.StringIO(answer.decode(), newline=""))) - 1
    return answer.count(b"\n") - 1


def _noted(answer: bytes, form: str, rows: int) -> bytes:
    """Return a table that says itself that rows are missing."""
    note = _NOTE.format(f"{rows} rows")
    match form:
        case "json":
            return answer[:-1] + b', "truncated": ' + json.dumps(note).encode() + b"}"
        case "xml":
            return answer + f"<!-- {note} -->".encode()
    return answer + f"# {note}\n".encode()


def _dumped(triples: Sequence[Any], form: str, size: int) -> bytes:
    out = _Bounded(size)
    ox.serialize(triples, out, format=GRAPHS[form])
    return out.getvalue()


def _noted_graph(answer: bytes, form: str, rows: int) -> bytes:
    note = _NOTE.format(f"{rows} triples")
    match form:
        case "rdf":
            return answer + f"<!-- {note} -->".encode()
        case "jsonld":
            raise TooLarge(f"more than {rows} triples, and JSON-LD has no place to say so: ask for Turtle")
    return answer + f"\n# {note}\n".encode()
