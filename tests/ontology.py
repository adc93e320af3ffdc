"""The ontology, written from what is said elsewhere: ``python tests/ontology.py`` writes it to ``kb/``.

Names, axioms and kinds come from ``vocabulary.py``, definitions from the comments in the rule files. Said
here is only what neither knows: the words of the export, what geometry guarantees, what others call it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

from deixis.rdf.namespaces import PREFIXES
from deixis.vocabulary import BASE, RELATIONS, TERMS, Term

ROOT = Path(__file__).resolve().parent.parent
ONTOLOGY = ROOT / "kb" / "ontology.ttl"
CONTEXT = ROOT / "kb" / "context.jsonld"

MORE_PREFIXES = {
    "owl": "http://www.w3.org/2002/07/owl#",
    "skos": "http://www.w3.org/2004/02/skos/core#",
    "knowrob": "http://knowrob.org/kb/knowrob.owl#",
    "soma": "http://www.ease-crc.org/ont/SOMA.owl#",
    "dul": "http://www.ontologydesignpatterns.org/ont/dul/DUL.owl#",
    "bot": "https://w3id.org/bot#",
    "kmi": "http://robots.kmi.ac.uk/ont/1.0/spatial-onto#",
}

HEAD = """\
# Written by tests/ontology.py from deixis.vocabulary and the comments in rules/: change those, not this.

<urn:deixis:ontology> a owl:Ontology ;
    dcterms:title "Deixis: commonsense spatial relations"@en ;
    dcterms:description '''Relations of things in a 3D scene, by the axioms of Chiatti et al. (KR 2021).
OWL 2 RL. What holds is concluded by the rules in rules/*.pl; a characteristic stands here only where
geometry or a rule guarantees it. Horizontal relations hold in the graph of one view: uniting the graphs
of views would make a thing both left and right of another.'''@en ;
    dcterms:license "Apache-2.0" .

dcterms:identifier a owl:DatatypeProperty .

prov:wasDerivedFrom a owl:ObjectProperty .

:axiom a owl:AnnotationProperty ;
    rdfs:label "axiom"@en ;
    skos:definition "Number in the paper, counted through the equations of its section 3."@en .
"""

ANNOTATIONS = (
    *(f"dcterms:{name}" for name in ("title", "description", "license")),
    *(f"skos:{name}" for name in ("definition", "notation", "scopeNote", "closeMatch", "relatedMatch")),
)

THEIR_CLASSES = (
    "geo:Feature",
    "geo:Geometry",
    "prov:Activity",
    "prov:Entity",
    "sosa:ObservableProperty",
    "sosa:Observation",
    "time:Instant",
    "time:Interval",
)

CLASSES = {
    "Scene": ("Things, surfaces and views of one place.", ["prov:Entity"], {}),
    "SpatialObject": (None, ["geo:Feature"], {}),
    "Surface": (
        "A wall, floor or ceiling: always a reference, without thickness.",
        [":SpatialObject"],
        {},
    ),
    "View": (
        "A pose that a scene is seen from, and the graph of what holds seen from there.",
        ["sosa:Observation", "prov:Entity"],
        {},
    ),
    "Region": ("The region of space a thing was seen to fill (axioms 1 to 3).", ["geo:Geometry"], {}),
    "BoxRegion": ("A box with a level base.", [":Region"], {}),
    "PointRegion": ("A set of points.", [":Region"], {}),
    "MeshRegion": ("A triangle mesh.", [":Region"], {}),
    "PolygonRegion": ("A flat bounded surface.", [":Region"], {}),
    "MinBoundBox": (
        "The minimum bounding box of a thing (axiom 10).",
        ["geo:Geometry"],
        {"closeMatch": ["kmi:BoundingBox3D"]},
    ),
    "Recognition": ("One of the names that a thing may have, with how sure that is.", [], {}),
    "Thresholds": ("The numbers that a scene is read with.", ["prov:Entity"], {}),
    "Withheld": (
        "A notice that a view tells no sides of a reference.",
        [],
        {},
    ),
    "Run": ("The derivation of all relations of a scene.", ["prov:Activity"], {}),
    "SceneGraph": (
        "The graph of things, and of the relations that no view changes.",
        ["prov:Entity"],
        {},
    ),
    "ViewGraph": ("The graph of the horizontal relations as seen from one view.", ["prov:Entity"], {}),
    "MetadataGraph": ("The graph that says where the others come from.", [], {}),
    "DerivationGraph": ("The graph of how each relation was derived.", ["prov:Entity"], {}),
    "HistoryGraph": ("The graph of when relations held, of a map.", ["prov:Entity"], {}),
    "Holding": (
        "A relation while it held: from its beginning on and before its end; without an end it holds still.",
        ["time:Interval"],
        {},
    ),
    "Step": ("One step of a proof.", [], {}),
    "Derivation": ("A relation that holds, with the step that concluded it.", [":Step"], {}),
    "Conclusion": ("A step by a rule.", [":Step"], {}),
    "Measurement": ("A step that was measured or given.", [":Step"], {}),
    "Comparison": ("A step that compares numbers.", [":Step"], {}),
    "Absence": ("A step that holds because nothing in the scene proves the contrary.", [":Step"], {}),
    "Conjunction": ("A step of several.", [":Step"], {}),
}
"""Class to definition, superclasses and links; a definition of None comes from the rule files."""

DOUBLE, INTEGER, STRING = "xsd:double", "xsd:integer", "xsd:string"

PROPERTIES = {
    "ofScene": ("The scene that this belongs to.", None, ":Scene"),
    "region": ("What a thing was seen to fill.", ":SpatialObject", ":Region"),
    "minBoundBox": ("A thing's minimum bounding box.", ":SpatialObject", ":MinBoundBox"),
    "seenIn": ("A view that a thing was seen in.", ":SpatialObject", ":View"),
    "recognised": ("What a thing was recognised as.", ":SpatialObject", ":Recognition"),
    "thresholds": ("What a scene is read with.", ":Scene", ":Thresholds"),
    "withholds": ("What a view says nothing of.", ":View", ":Withheld"),
    "relation": ("The relation that was derived, or that held.", None, None),
    "figure": ("What is placed.", None, None),
    "reference": ("What it is placed by.", None, None),
    "inGraph": ("The graph that holds the relation.", ":Derivation", None),
    "premise": ("What a step rests on.", ":Step", ":Step"),
    "ordinal": ("Place in an order, from 0.", None, INTEGER),
    "measuredAs": ("What a thing was measured as: box, outline, hull or mesh.", ":SpatialObject", STRING),
    "labelName": ("A name.", ":Recognition", STRING),
    "score": ("How sure, from 0 to 1.", ":Recognition", DOUBLE),
    **{f"center{axis}": (f"{axis} of the centre, metres, world frame.", None, DOUBLE) for axis in "XYZ"},
    **{f"size{axis}": (f"Full extent along the box's own {axis}, metres.", None, DOUBLE) for axis in "XYZ"},
    "yaw": ("Radians, counter-clockwise, from the world's X axis to the box's.", None, DOUBLE),
    "vertices": ("Points, metres: a comma between points, a space between numbers.", ":Region", STRING),
    "faces": ("Triangles: positions of vertices, counted from 0, written as those.", ":MeshRegion", STRING),
    "strays": ("What becomes of stray points: drop or refuse.", ":Scene", STRING),
    "granularity": (
        "D, metres (axiom 5): a gap up to it is contact.",
        ":Thresholds",
        DOUBLE,
    ),
    "penetration": ("P, metres: an overlap up to it is contact.", ":Thresholds", DOUBLE),
    "closeness": ("T, metres (axiom 15): at most this distance is near.", ":Thresholds", DOUBLE),
    "halfspaceScale": ("s (axiom 20): a halfspace is s times the full extent deep.", ":Thresholds", DOUBLE),
    "poseNoise": ("Metres: what holds by less is uncertain.", ":Thresholds", DOUBLE),
    "pieceGap": ("Metres: points closer than this are in one piece.", ":Thresholds", DOUBLE),
    **{f"position{axis}": (f"{axis} of the viewer, metres, world frame.", ":View", DOUBLE) for axis in "XYZ"},
    "heading": ("Radians from the world's X axis.", ":View", DOUBLE),
    "stamp": ("Seconds since the epoch: of the recording, or of a moment.", None, DOUBLE),
    "reason": ("Why nothing is said.", ":Withheld", STRING),
    "regionModel": ("What things are measured as: box, hull or mesh.", ":Run", STRING),
    "sha256": ("Of a rule file's text.", None, STRING),
    "margin": (
        "Metres by which a measured length would have to change for the answer to change.",
        ":Step",
        DOUBLE,
    ),
    "value": ("What was measured: metres, or cubic metres of a volume.", ":Step", DOUBLE),
    "quantity": ("What the number that was measured is called.", ":Step", STRING),
    "threshold": ("What the number that it was compared with is called.", ":Step", STRING),
    "comparedWith": ("The number that it was compared with, metres.", ":Step", DOUBLE),
    "witness": (
        "Where a step was measured: the figure's point, then the reference's or the one in the plane.",
        ":Step",
        "geo:Geometry",
    ),
    "takenFrom": ("What the witness was taken from: box, outline, hull or mesh.", ":Step", STRING),
    "direction": (
        "Unit vector x y z from reference to figure, or to where the figure meets the halfspace.",
        ":Step",
        STRING,
    ),
    "bound": (
        "Which bound of a halfspace decides: face, middle, end, side or height.",
        ":Step",
        STRING,
    ),
    "seenFrom": ("The view that a step, or a relation that held, depends on.", None, ":View"),
    "says": ("The step in words.", ":Step", STRING),
    "ruleFile": ("The file of the rule.", ":Step", STRING),
    "ruleLine": ("Where the rule begins in it.", ":Step", INTEGER),
}
"""Property to definition, domain and range: a datatype, a class or nothing."""

SYMMETRIC = ("isClose", "touches", "intersects")

ASYMMETRIC = ("partIn",)

IMPLIES = {
    "touches": [":isClose"],
    "intersects": [":isClose"],
    "completelyContains": [":intersects"],
    **{f"{side}Strict": [f":{side}Relaxed"] for side in ("east", "west", "north", "south", "above", "below")},
    "above": [":aboveRelaxed"],
    "below": [":belowRelaxed"],
    "rightOf": [":beside"],
    "leftOf": [":beside"],
    "onTopOf": [":above", ":touches"],
    "leansOn": [":touches"],
    "affixedOn": [":touches"],
    "partIn": [":intersects"],
    "inside": ["_:completelyContainedBy"],
    "near": [":isClose"],
}

EXCLUDES = {
    "touches": [":intersects"],
    "leansOn": [":above", ":below"],
    "affixedOn": [":above"],
}

CLOSE = {
    "isClose": ["kmi:IsNearTo"],
    "touches": ["geo:sfTouches"],
    "intersects": ["geo:sfIntersects"],
    "completelyContains": ["geo:sfContains", "bot:containsElement", "soma:containsObject"],
    "eastRelaxed": ["kmi:isEastOf"],
    "westRelaxed": ["kmi:isWestOf"],
    "northRelaxed": ["kmi:isNorthOf"],
    "southRelaxed": ["kmi:isSouthOf"],
    "above": ["kmi:isAbove", "knowrob:isAboveOf"],
    "below": ["kmi:isBelow", "knowrob:isBelowOf"],
    "rightOf": ["knowrob:isRightOf"],
    "leftOf": ["knowrob:isLeftOf"],
    "inFrontOf": ["knowrob:isInFrontOf"],
    "behind": ["knowrob:isBehindOf"],
    "beside": ["kmi:IsNextTo"],
    "onTopOf": ["soma:isOntopOf", "knowrob:isOntopOf"],
    "inside": ["geo:sfWithin", "soma:isInsideOf", "knowrob:isInsideOf"],
    "near": ["dul:nearTo", "kmi:IsNearTo"],
}

RELATED = {"leansOn": ["soma:isSupportedBy"], "affixedOn": ["soma:isLinkedTo"]}


def definitions() -> dict[str, str]:
    """Return what the comment of each predicate in the rule files says, without the number of its axiom."""
    found = {}
    for name in ("facts", "topology", "direction", "commonsense"):
        text = (ROOT / "rules" / f"{name}.pl").read_text(encoding="utf-8")
        for head, body in re.findall(r"^%!  (.+?) is \w+\.\n%\n((?:%   .+\n)+)", text, re.MULTILINE):
            predicate = head.partition("(")[0]
            said = " ".join(line.removeprefix("%").strip() for line in body.splitlines())
            arity = head.count(",") + 1
            found[f"{predicate}/{arity}"] = re.sub(r"^Axioms? [^.:]*[.:] ", "", said)
    return found


def ontology() -> str:
    """Return the ontology in Turtle, a block for each term, with an empty line between blocks."""
    said = definitions()
    lines = [f"@prefix {name}: <{iri}> ." for name, iri in sorted((PREFIXES | MORE_PREFIXES).items())]
    theirs = [f"{name} a owl:AnnotationProperty ." for name in ANNOTATIONS]
    theirs += [f"{name} a owl:Class ." for name in THEIR_CLASSES]
    blocks = ["\n".join(lines), HEAD.rstrip(), "\n".join(theirs)]
    for name, (text, above, links) in CLASSES.items():
        term = next((one for one in TERMS if one.rdf == name), None)
        facts = [("rdfs:subClassOf", above), *((f"skos:{kind}", of) for kind, of in links.items())]
        if term is None:
            blocks.append(_block(name, ["owl:Class"], text or "", facts))
        else:
            blocks.append(_block(name, ["owl:Class"], said[_key(term)], [*_numbered(term), *facts]))
    blocks += [_measure(term, said) for term in TERMS if term.kind == "measure" and term.rdf not in CLASSES]
    blocks += [_relation(term, said) for term in (*BASE, *RELATIONS)]
    for name, (text, domain, given) in PROPERTIES.items():
        kind = "owl:DatatypeProperty" if given in (DOUBLE, INTEGER, STRING) else "owl:ObjectProperty"
        facts = [("rdfs:domain", [domain] if domain else []), ("rdfs:range", [given] if given else [])]
        if name == "premise":
            facts.append(("rdfs:subPropertyOf", ["prov:wasDerivedFrom"]))
        blocks.append(_block(name, [kind], text, facts))
    blocks.append(
        ":SpatialArrangement a owl:NamedIndividual, sosa:ObservableProperty ;\n"
        '    rdfs:label "spatial arrangement"@en ;\n'
        '    skos:definition "What a view observes of a scene: where its things are."@en .'
    )
    # A blank node with a name: the same text in every format, each time.
    blocks.append("_:completelyContainedBy owl:inverseOf :completelyContains .")
    kinds = [f":{name}" for name in CLASSES if name.endswith("Region") and name != "Region"]
    blocks.append("\n".join(f"{one} owl:disjointWith {other} ." for one, other in combinations(kinds, 2)))
    return "\n\n".join(blocks) + "\n"


def context() -> str:
    """Return the JSON-LD context: the properties by their local names, links and numbers without ceremony."""
    terms: dict[str, object] = {"@version": 1.1, "@vocab": PREFIXES[""]}
    terms |= {name: iri for name, iri in PREFIXES.items() if name}
    terms |= {"id": "@id", "type": "@type", "label": "rdfs:label", "identifier": "dcterms:identifier"}
    for term in (*BASE, *RELATIONS):
        terms[term.rdf] = {"@type": "@id"}
    for name, (_, _, given) in PROPERTIES.items():
        if given != STRING:
            terms[name] = {"@type": given if given in (DOUBLE, INTEGER) else "@id"}
    terms["axiom"] = {"@type": INTEGER}
    return json.dumps({"@context": terms}, indent=1) + "\n"


def _relation(term: Term, said: dict[str, str]) -> str:
    kinds = ["owl:ObjectProperty", "owl:IrreflexiveProperty"]
    kinds += ["owl:SymmetricProperty"] if term.rdf in SYMMETRIC else []
    kinds += ["owl:AsymmetricProperty"] if term.rdf in ASYMMETRIC else []
    facts = [
        *_numbered(term),
        ("rdfs:domain", [":SpatialObject"]),
        ("rdfs:range", [":SpatialObject"]),
        ("rdfs:subPropertyOf", IMPLIES.get(term.rdf, [])),
        ("owl:propertyDisjointWith", EXCLUDES.get(term.rdf, [])),
        ("skos:closeMatch", CLOSE.get(term.rdf, [])),
        ("skos:relatedMatch", RELATED.get(term.rdf, [])),
    ]
    if term.view:
        facts.append(("skos:scopeNote", ['"Holds in the graph of one view."@en']))
    return _block(term.rdf, kinds, said[_key(term)], facts)


def _measure(term: Term, said: dict[str, str]) -> str:
    note = f'"A row of {term.arity} arguments: :{term.rdf}.1 and so on; deixis rules compile --to sparql."@en'
    facts = [*_numbered(term), ("skos:scopeNote", [note])]
    return _block(term.rdf, ["owl:Class"], said[_key(term)], facts)


def _numbered(term: Term) -> list[tuple[str, list[str]]]:
    return [(":axiom", [str(term.axiom)]), ("skos:notation", [json.dumps(_key(term))])]


def _key(term: Term) -> str:
    return f"{term.name}/{term.arity}"


def _block(name: str, kinds: list[str], text: str, facts: list[tuple[str, list[str]]]) -> str:
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name).lower()
    rows = [
        f":{name} a {', '.join(kinds)}",
        f"rdfs:label {json.dumps(words)}@en",
        f"skos:definition {json.dumps(text, ensure_ascii=False)}@en",
        *_rows(facts),
    ]
    return " ;\n    ".join(rows) + " ."


def _rows(facts: list[tuple[str, list[str]]]) -> Iterator[str]:
    for predicate, values in facts:
        if values:
            yield f"{predicate} {', '.join(values)}"


if __name__ == "__main__":
    ONTOLOGY.write_text(ontology(), encoding="utf-8", newline="\n")
    CONTEXT.write_text(context(), encoding="utf-8", newline="\n")
