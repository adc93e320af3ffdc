"""Where the relations come from: SOSA for what was observed, PROV-O for what was concluded from it."""

from __future__ import annotations

import hashlib
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Final

from deixis._files import rules_dir
from deixis.rdf.knowledge import Knowledge
from deixis.rdf.layout import TERM
from deixis.rdf.names import SceneNames
from deixis.rdf.namespaces import DCTERMS, PROV, SOSA, XSD
from deixis.rdf.quads import GraphWriter
from deixis.rdf.scene import write_scene
from deixis.rdf.terms import IDENTIFIER

VERSION: Final = version("deixis")
ENGINE: Final = f"urn:deixis:engine:{VERSION}"
RULES: Final = "urn:deixis:rules:"

_RULE_FILES: Final = ("facts", "topology", "direction", "commonsense")
_YEARS: Final = 4102444800.0
"""Seconds since the epoch until 2100: a later stamp is no time of this clock."""


@cache
def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def write_metadata(to: GraphWriter, kb: Knowledge, names: SceneNames) -> None:
    """Write the metadata graph: the scene, its views, and the run that derived the relations."""
    write_scene(to, kb.scene, names)
    _graphs(to, kb, names)
    _views(to, kb, names)
    _run(to, kb, names)


def _graphs(to: GraphWriter, kb: Knowledge, names: SceneNames) -> None:
    for graph, kind in (
        (names.scene, "SceneGraph"),
        (names.metadata, "MetadataGraph"),
        (names.derivations, "DerivationGraph"),
        *((names.view(view.id), "ViewGraph") for view in kb.scene.views),
    ):
        to.typed(graph, TERM + kind)
        to.link(graph, TERM + "ofScene", names.scene)
    for graph in (names.scene, names.derivations, *(names.view(view.id) for view in kb.scene.views)):
        to.typed(graph, PROV + "Entity")
        to.link(graph, PROV + "wasGeneratedBy", names.run)


def _views(to: GraphWriter, kb: Knowledge, names: SceneNames) -> None:
    for view in kb.scene.views:
        iri = names.view(view.id)
        to.typed(iri, SOSA + "Observation")
        to.link(iri, SOSA + "hasFeatureOfInterest", names.scene)
        to.link(iri, SOSA + "observedProperty", TERM + "SpatialArrangement")
        to.link(iri, SOSA + "madeBySensor", f"{iri}:sensor")
        to.typed(f"{iri}:sensor", SOSA + "Sensor")
        to.link(iri, PROV + "wasDerivedFrom", names.scene)
        if view.stamp is not None and 0.0 <= view.stamp < _YEARS:
            when = datetime.fromtimestamp(view.stamp, UTC).isoformat().replace("+00:00", "Z")
            to.literal(iri, SOSA + "resultTime", when, XSD + "dateTime")
    for number, notice in enumerate(kb.withheld):
        iri = f"{names.metadata}:withheld:{number}"
        to.typed(iri, TERM + "Withheld")
        to.link(names.view(notice.view), TERM + "withholds", iri)
        to.link(iri, TERM + "reference", names.thing(notice.reference))
        to.text(iri, TERM + "reason", notice.reason)


def _run(to: GraphWriter, kb: Knowledge, names: SceneNames) -> None:
    to.typed(names.run, PROV + "Activity", TERM + "Run")
    to.text(names.run, TERM + "regionModel", kb.region)
    to.link(names.run, PROV + "used", names.thresholds)
    to.link(names.run, PROV + "wasAssociatedWith", ENGINE)
    association = f"{names.run}:association"
    to.link(names.run, PROV + "qualifiedAssociation", association)
    to.typed(association, PROV + "Association")
    to.link(association, PROV + "agent", ENGINE)
    to.typed(ENGINE, PROV + "SoftwareAgent")
    to.text(ENGINE, IDENTIFIER, "deixis")
    to.text(ENGINE, DCTERMS + "hasVersion", VERSION)
    for path in (*(rules_dir() / f"{name}.pl" for name in _RULE_FILES), *kb.rule_files):
        plan = RULES + _digest(path)
        to.link(association, PROV + "hadPlan", plan)
        to.typed(plan, PROV + "Plan", PROV + "Entity")
        to.text(plan, IDENTIFIER, path.name)
        to.text(plan, TERM + "sha256", _digest(path))
