"""What people are told of a SPARQL text that the engine cannot read; the errors are the engine's own."""

from __future__ import annotations

import pyoxigraph as ox
import pytest

from deixis.rdf.complaints import complaint


@pytest.mark.parametrize(
    ("text", "prefix", "iri"),
    [
        ("ASK { ?a rdfs:label ?b }", "rdfs", "http://www.w3.org/2000/01/rdf-schema#"),
        ("ASK { ?a\r\n rdfs: ?b }", "rdfs", "http://www.w3.org/2000/01/rdf-schema#"),
        ("ASK { ?a deixis:near ?b }", "deixis", "urn:deixis:term:"),
        ("ASK { ?ü foaf:ü ?b }", "foaf", "..."),
        ("PREFIX a: <urn:a> ASK { ?x a:b 'c:d', b:c }", "b", "..."),
    ],
)
def test_a_prefix_that_is_not_declared_is_named(text: str, prefix: str, iri: str) -> None:
    with pytest.raises(SyntaxError) as raised:
        ox.Store().query(text)
    told = f"the prefix {prefix}: is not declared; begin with PREFIX {prefix}: <{iri}>"
    assert complaint(raised.value, text) == told


@pytest.mark.parametrize(
    ("text", "place", "more"),
    [
        ("SELEC * {}", 'line 1, column 10, after "SELEC * {"', ""),
        ("ASK {\n <urn:a:b> ?x ?y ; }}", 'line 2, column 22, after " <urn:a:b> ?x ?y ; }}"', ""),
        ("prefix : <urn:y> ASK { ?x :z ", 'line 1, column 30, after "prefix : <urn:y> ASK { ?x :z "', ""),
        ("", 'line 1, column 1, after ""', ""),
        (
            "SELECT ?x {} GROUP BY ?y",
            'line 1, column 25, after "SELECT ?x {} GROUP BY ?y"',
            "; The SELECT contains a variable that is unbound",
        ),
    ],
)
def test_else_the_place_is(text: str, place: str, more: str) -> None:
    with pytest.raises(SyntaxError) as raised:
        ox.Store().query(text)
    assert complaint(raised.value, text) == f"a syntax error at {place}{more}"


def test_a_long_text_is_looked_at_in_a_moment() -> None:
    text = "ASK { " + " ".join(f"p{n}:x" for n in range(200_000))
    assert complaint(SyntaxError(f"error at 1:{len(text)}: expected x"), text) == (
        "the prefix p199999: is not declared; begin with PREFIX p199999: <...>"
    )
