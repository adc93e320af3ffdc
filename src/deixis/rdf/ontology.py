"""The ontology as text: all of it, or what it says of one term."""

from __future__ import annotations

import difflib

from deixis._files import kb_dir
from deixis.errors import QueryError
from deixis.rdf.layout import TERM
from deixis.strict_json import quoted


def ontology(form: str = "ttl") -> str:
    """Return ``kb/ontology.ttl`` as Turtle, or as ``owl`` (RDF/XML) or ``nt`` for tools that read no Turtle.

    Examples
    --------
    >>> "<urn:deixis:term:onTopOf>" in ontology("nt")
    True
    """
    path = kb_dir() / "ontology.ttl"
    if form == "ttl":
        return path.read_text(encoding="utf-8")
    from deixis.rdf.namespaces import PREFIXES
    from deixis.rdf.oxigraph import ox
    from deixis.rdf.quads import in_order

    turtle = ox.parse(path=path, format=ox.RdfFormat.TURTLE, rename_blank_nodes=False)
    triples = [ox.Triple(one.subject, one.predicate, one.object) for one in in_order(turtle)]
    if form == "nt":
        text = ox.serialize(triples, format=ox.RdfFormat.N_TRIPLES)
    else:
        text = ox.serialize(triples, format=ox.RdfFormat.RDF_XML, prefixes={"deixis": PREFIXES[""]})
    assert text is not None  # noqa: S101 - None is for output to a file
    return text.decode()


def definition(name: str) -> str:
    """Return what the ontology says of one term, in Turtle without the prefixes.

    Parameters
    ----------
    name : str
        The term's IRI, or its name in RDF.

    Raises
    ------
    QueryError
        There is no such term.

    Examples
    --------
    >>> print(definition("urn:deixis:term:affixedOn").splitlines()[1].strip())
    rdfs:label "affixed on"@en ;
    """
    wanted = name.removeprefix(TERM)
    blocks = {
        block[1:].split(" ", 1)[0]: block for block in ontology().split("\n\n") if block.startswith(":")
    }
    if wanted not in blocks:
        near = difflib.get_close_matches(wanted, blocks, n=1)
        hint = f"did you mean {near[0]!r}?" if near else "'deixis ontology' prints them all"
        raise QueryError(f"the ontology has no term {quoted(name)}: {hint}")
    return blocks[wanted].rstrip()
