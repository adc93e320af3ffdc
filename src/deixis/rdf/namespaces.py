"""The namespaces that an export uses: our terms, and the vocabularies they stand beside."""

from __future__ import annotations

from typing import Final

from deixis.rdf.layout import TERM

RDF: Final = "http://www.w3.org/1999/02/22-rdf-syntax-ns#"
RDFS: Final = "http://www.w3.org/2000/01/rdf-schema#"
XSD: Final = "http://www.w3.org/2001/XMLSchema#"
DCTERMS: Final = "http://purl.org/dc/terms/"
PROV: Final = "http://www.w3.org/ns/prov#"
SOSA: Final = "http://www.w3.org/ns/sosa/"
TIME: Final = "http://www.w3.org/2006/time#"
GEO: Final = "http://www.opengis.net/ont/geosparql#"

PREFIXES: Final = {
    "": TERM,
    "rdf": RDF,
    "rdfs": RDFS,
    "xsd": XSD,
    "dcterms": DCTERMS,
    "prov": PROV,
    "sosa": SOSA,
    "geo": GEO,
    "time": TIME,
}
"""What they are called in Turtle, in the query page and in the examples."""
