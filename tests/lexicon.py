"""The lexicon, written from ``deixis.words.lexicon``: ``python tests/lexicon.py`` writes it to ``kb/``."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path

from deixis.vocabulary import BY_NAME
from deixis.words.lexicon import ENTRIES, NOT_GROUNDED, Entry

ROOT = Path(__file__).resolve().parent.parent
LEXICON = ROOT / "kb" / "lexicon.ttl"

HEAD = """\
@prefix : <urn:deixis:word:> .
@prefix deixis: <urn:deixis:term:> .
@prefix dcterms: <http://purl.org/dc/terms/> .
@prefix lexinfo: <http://www.lexinfo.net/ontology/2.0/lexinfo#> .
@prefix lime: <http://www.w3.org/ns/lemon/lime#> .
@prefix ontolex: <http://www.w3.org/ns/lemon/ontolex#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix skos: <http://www.w3.org/2004/02/skos/core#> .

# Written by tests/lexicon.py from deixis.words.lexicon: change that, not this.

<urn:deixis:lexicon> a lime:Lexicon ;
    dcterms:title "Deixis: English spatial prepositions"@en ;
    dcterms:description '''The prepositions of Landau and Jackendoff (1993) and what they say of things in a
scene. A sense refers to the relation that makes it true; rules/prepositions.pl says when a person would
accept the word. Words without a sense here are listed with the reason.'''@en ;
    dcterms:license "Apache-2.0" ;
    lime:language "en" .

:visualGenome a owl:AnnotationProperty ;
    rdfs:label "Visual Genome"@en ;
    skos:definition "Predicate of the Visual Genome data set with this meaning."@en .

:spatialSense a owl:AnnotationProperty ;
    rdfs:label "SpatialSense"@en ;
    skos:definition "Predicate of the SpatialSense data set with this meaning."@en .

:notGrounded a owl:AnnotationProperty ;
    rdfs:label "not grounded"@en ;
    skos:definition "Why a word stands for no relation here."@en .
"""


def lexicon() -> str:
    """Return the lexicon as Turtle."""
    return "\n".join((HEAD, *map(_entry, ENTRIES), *_silent()))


def _entry(entry: Entry) -> str:
    """Return an entry with its forms and senses."""
    word, *others = entry.forms
    lines = [
        f":{_name(entry.word)} a ontolex:LexicalEntry ;",
        f"    skos:notation {_text(entry.word)} ;",
        "    lexinfo:partOfSpeech lexinfo:preposition ;",
        f"    ontolex:canonicalForm [ ontolex:writtenRep {_text(word)}@en ] ;",
        *(f"    ontolex:otherForm [ ontolex:writtenRep {_text(one)}@en ] ;" for one in others),
        *(f"    :visualGenome {_text(one)} ;" for one in entry.visual_genome),
        *(f"    :spatialSense {_text(one)} ;" for one in entry.spatial_sense),
        f"    ontolex:sense {', '.join(_sense(entry, at) for at in range(len(entry.senses)))} .",
        "",
    ]
    for at, sense in enumerate(entry.senses):
        lines += [
            f"{_sense(entry, at)} a ontolex:LexicalSense ;",
            f"    skos:definition {_text(sense.gloss)}@en ;",
            f"    ontolex:reference deixis:{BY_NAME[sense.predicate].rdf} .",
            "",
        ]
    return "\n".join(lines)


def _silent() -> Iterator[str]:
    for word, reason in NOT_GROUNDED.items():
        yield (
            f":{_name(word)} a ontolex:LexicalEntry ;\n"
            f"    lexinfo:partOfSpeech lexinfo:preposition ;\n"
            f"    ontolex:canonicalForm [ ontolex:writtenRep {_text(word)}@en ] ;\n"
            f"    :notGrounded {_text(reason)}@en .\n"
        )


def _name(word: str) -> str:
    return re.sub(r"\W", "_", word)


def _sense(entry: Entry, at: int) -> str:
    return f":{_name(entry.word)}-{at + 1}"


def _text(text: str) -> str:
    return json.dumps(text)


if __name__ == "__main__":
    LEXICON.write_text(lexicon(), encoding="utf-8")
