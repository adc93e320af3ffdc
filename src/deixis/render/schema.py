"""The JSON Schema of explanations: what ``why``, ``why-not`` and ``check`` give in JSON."""

from __future__ import annotations

from typing import Any, Final, get_args

from deixis.bounds import BOUNDS
from deixis.evidence import Unit
from deixis.facts import SolidModel

SCHEMA_ID: Final = "urn:deixis:schema:explanation:1"

Schema = dict[str, Any]


def explanation_schema() -> Schema:
    """Return the JSON Schema of explanations, as exported to ``kb/explanation.schema.json``.

    Examples
    --------
    >>> sorted(explanation_schema()["$defs"])[:4]
    ['answer', 'evidence', 'inspection', 'miss']
    """
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": SCHEMA_ID,
        "title": "Deixis explanation",
        "description": "Why a relation holds, why it does not, or which rules a scene breaks.",
        "anyOf": [{"$ref": f"#/$defs/{name}"} for name in ("answer", "proofs", "refusal", "inspection")],
        "$defs": {
            "answer": _answer(),
            "proofs": _proofs(),
            "refusal": _refusal(),
            "miss": _miss(),
            "inspection": _inspection(),
            "violation": _violation(),
            "step": _step(),
            "rule": _closed(
                "Where a rule stands.",
                {
                    "file": _text("Name of the rule file."),
                    "line": {"type": "integer", "minimum": 1, "description": "First line of the clause."},
                },
            ),
            "evidence": _evidence(),
            "witness": _witness(),
            "plane": _plane(),
            "value": _closed(
                "A number with its name, exact.",
                {
                    "name": _text("What it is called."),
                    "value": {"type": "number", "description": "In the unit."},
                    "unit": {"enum": list(get_args(Unit)), "description": "Metres, cubic metres, or none."},
                },
            ),
            "point": {
                "type": "array",
                "items": {"type": "number"},
                "minItems": 3,
                "maxItems": 3,
                "description": "x, y, z in the world frame: metres, or a direction.",
            },
            "models": {
                "type": "object",
                "additionalProperties": {"enum": list(get_args(SolidModel))},
                "description": "Of each thing, by its id, what it was measured as.",
            },
        },
    }


def _answer() -> Schema:
    return _closed(
        "Why something holds, or how far it is from holding.",
        {
            "goal": _text("What was asked."),
            "holds": {"type": "boolean", "description": "Whether it does."},
            "text": _text("The answer in a sentence."),
            "proof": _maybe("step", "Why; null where it does not hold."),
            "nearest": _maybe(
                "step", "What comes closest, where it does not; null where nothing within reach does."
            ),
            "measured_as": _ref("models", "What each thing spoken of was measured as."),
        },
        optional=("goal",),
    )


def _proofs() -> Schema:
    return _closed(
        "All proofs of something, the best first.",
        {
            "goal": _text("What was asked."),
            "holds": {"type": "boolean", "description": "Whether it does."},
            "proofs": {"type": "array", "items": {"$ref": "#/$defs/step"}},
            "truncated": {"type": "boolean", "description": "Whether there are more than were asked for."},
        },
        optional=("goal",),
    )


def _refusal() -> Schema:
    return _closed(
        "Why something does not hold.",
        {
            "goal": _text("What was asked."),
            "holds": {"type": "boolean", "description": "Whether it holds after all."},
            "text": _text("What holds or does not, in a sentence."),
            "hindrance": {
                "type": ["string", "null"],
                "description": "What keeps it from being stated whatever was measured.",
            },
            "because": {
                "type": "array",
                "items": {"type": "string"},
                "description": "What keeps it from holding, each as a clause after the text.",
            },
            "misses": _list("miss", "One for each rule whose facts are there, nearest first."),
        },
        optional=("goal",),
    )


def _miss() -> Schema:
    return _closed(
        "A rule that could have concluded it.",
        {
            "derivation": _ref("step", "What comes closest; what fails has a negative margin."),
            "obstacles": {
                "type": "array",
                "items": {"type": "string"},
                "description": "What fails, each in a sentence.",
            },
        },
    )


def _inspection() -> Schema:
    rule = _closed(
        "A rule that was checked.",
        {
            "rule": _text("Its name."),
            "says": _text("What the comment in front of it says."),
            "file": _text("Name of the rule file."),
            "line": {"type": "integer", "minimum": 1, "description": "First line of the first clause."},
        },
    )
    return _closed(
        "Which rules a scene breaks.",
        {
            "scene": _text("Its id."),
            "view": {"type": ["string", "null"], "description": "The only view looked from; null for all."},
            "checked": _closed(
                "What was checked.",
                {
                    "rules": {"type": "array", "items": rule, "description": "In the order of their files."},
                    "things": {"type": "integer", "minimum": 0, "description": "How many."},
                },
            ),
            "violations": _list("violation", "In the order of the rules, then by ids."),
        },
    )


def _violation() -> Schema:
    return _closed(
        "A breach of a rule.",
        {
            "rule": _text("Name of the rule."),
            "things": _texts("Ids: the thing at fault, and another where the rule names one."),
            "margin": _margin("Metres until it ceases; null where no length decides."),
            "text": _text("The breach in a sentence."),
            "proof": _maybe("step", "Why; null where no reasons were asked for."),
        },
    )


def _step() -> Schema:
    return _closed(
        "One step of a proof.",
        {
            "kind": {
                "enum": ["rule", "fact", "comparison", "negation", "conjunction"],
                "description": "A conclusion by a rule, something measured or given, two numbers compared, "
                "the absence of a proof, or several things at once.",
            },
            "predicate": _text("Name of the predicate, or the comparison's operator."),
            "args": {
                "type": "array",
                "items": {"type": ["string", "number", "null"]},
                "description": "Ids and numbers; null where anything may stand.",
            },
            "text": _text("The step in a sentence."),
            "clause": {
                "type": ["string", "null"],
                "description": "Of a first reason its text after the conclusion, with a pronoun for what "
                "both are about; null where that is its text.",
            },
            "margin": _margin("Metres until the step changes its answer; negative where it fails."),
            "axiom": {"type": ["integer", "null"], "description": "Number in the paper."},
            "rule": _maybe("rule", "Of a conclusion its rule."),
            "shown": {"type": "boolean", "description": "Whether a person needs this step."},
            "evidence": _maybe("evidence", "What a leaf rests on."),
            "children": _list("step", "The reasons; of an absence, what came closest to refuting it."),
        },
    )


def _evidence() -> Schema:
    return _closed(
        "What a leaf of a proof rests on.",
        {
            "values": _list("value", "What was measured."),
            "thresholds": _list("value", "What it was compared with."),
            "margin": _margin("Metres to spare, negative where it fails; null where no length decides."),
            "witness": _maybe("witness", "What to light up in a picture."),
        },
    )


def _witness() -> Schema:
    return _closed(
        "Geometry to be shown.",
        {
            "things": _texts("Ids, the figure first."),
            "points": {
                "anyOf": [
                    {
                        "type": "array",
                        "items": {"$ref": "#/$defs/point"},
                        "minItems": 2,
                        "maxItems": 2,
                    },
                    {"type": "null"},
                ],
                "description": "What is measured lies between them: the figure's point, and the reference's "
                "or the one in the plane.",
            },
            "normal": _maybe("point", "Unit vector from reference to figure along which they are parted."),
            "plane": _maybe("plane", "Of a halfspace the bound that decides."),
            "view": {"type": ["string", "null"], "description": "Id of the view; null where all agree."},
            "measured_as": _ref("models", "What points and plane were taken from."),
        },
    )


def _plane() -> Schema:
    return _closed(
        "A bound of a halfspace.",
        {
            "point": _ref("point", "On it."),
            "normal": _ref("point", "Unit vector to where the fact holds."),
            "bound": {"enum": list(BOUNDS), "description": "Which of the halfspace's bounds it is."},
        },
    )


def _closed(says: str, properties: Schema, optional: tuple[str, ...] = ()) -> Schema:
    return {
        "type": "object",
        "description": says,
        "properties": properties,
        "required": [name for name in properties if name not in optional],
        "additionalProperties": False,
    }


def _text(says: str) -> Schema:
    return {"type": "string", "description": says}


def _texts(says: str) -> Schema:
    return {"type": "array", "items": {"type": "string"}, "description": says}


def _margin(says: str) -> Schema:
    return {"type": ["number", "null"], "description": says}


def _ref(name: str, says: str) -> Schema:
    return {"$ref": f"#/$defs/{name}", "description": says}


def _maybe(name: str, says: str) -> Schema:
    return {"anyOf": [{"$ref": f"#/$defs/{name}"}, {"type": "null"}], "description": says}


def _list(name: str, says: str) -> Schema:
    return {"type": "array", "items": {"$ref": f"#/$defs/{name}"}, "description": says}
