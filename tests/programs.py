"""Random rule files: safe and stratified by how they are made, with recursion, denials and comparisons."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

NAMES = ("a", "b", "c", "d", "'X y'")
FACTS = {"e": "nn", "f": "nn", "g": "n", "w": "nd"}
"""What a program lists itself: n for a name, d for a number."""

THEORY = {
    "near": "nn", "touches": "nn", "on_top_of": "nn", "above": "nn", "surface": "n", "spatial_obj": "n",
    "distance": "nnd", "separation": "nnd", "figure_reference": "nn", "leans_on": "nn",
    "adj_sr_card": "nnd", "left_of": "nnn",
}  # fmt: skip
SHAPES = ("n", "nn", "nn", "nd", "nnd")
NUMBERS = ("0", "1", "2.5", "-1", "0.02", "0.3", "-0.04", "1.0e-3", "3")


@dataclass(frozen=True)
class Program:
    """The text of a program, and the predicates that it has rules for, with their shapes."""

    text: str
    shapes: dict[str, str]

    @property
    def wanted(self) -> list[tuple[str, int]]:
        return [(name, len(shape)) for name, shape in self.shapes.items()]


def random_program(draw: Random) -> Program:
    """Return a program of up to six predicates on up to three levels; denials reach down only."""
    lines = [_fact(draw, name, shape) for name, shape in FACTS.items() for _ in range(draw.randint(1, 5))]
    shapes = {f"p{at}": draw.choice(SHAPES) for at in range(draw.randint(1, 6))}
    level = {name: draw.randint(0, 2) for name in shapes}
    for name, shape in shapes.items():
        same = {one: shapes[one] for one in shapes if level[one] <= level[name]}
        lower = {one: shapes[one] for one in shapes if level[one] < level[name]}
        lines += [_rule(draw, name, shape, same, lower) for _ in range(draw.randint(1, 3))]
        if draw.randint(0, 5) == 0:
            lines.append(_fact(draw, name, shape))
    return Program("\n".join(sorted(lines, key=lambda line: line.partition("(")[0])) + "\n", shapes)


def _fact(draw: Random, name: str, shape: str) -> str:
    values = [draw.choice(NAMES if kind == "n" else NUMBERS) for kind in shape]
    return f"{name}({', '.join(values)})."


class _Body:
    """A body while it grows: its goals, and which variables are bound."""

    def __init__(self) -> None:
        self.goals: list[str] = []
        self.names: list[str] = []
        self.numbers: list[str] = []
        self.fresh = 0

    def atom(
        self, draw: Random, name: str, shape: str, within: list[str] | None = None
    ) -> tuple[str, list[str], list[str]]:
        """Return an atom with the names and numbers that it binds; inside a denial given the names there."""
        local = within is not None
        known = self.names if within is None else within
        args: list[str] = []
        names: list[str] = []
        numbers: list[str] = []
        for kind in shape:
            if kind == "d":
                self.fresh += 1
                args.append(f"D{self.fresh}")
                numbers.append(args[-1])
                continue
            choice = draw.randint(0, 9)
            if choice < 5 and known:
                args.append(draw.choice(known))
            elif choice == 9:
                args.append(draw.choice(NAMES))
            elif choice == 8 and not local:
                args.append("_")
            else:
                self.fresh += 1
                args.append(f"{'L' if local else 'X'}{self.fresh}")
                names.append(args[-1])
        return f"{name}({', '.join(args)})", names, numbers


def _rule(draw: Random, head: str, shape: str, same: dict[str, str], lower: dict[str, str]) -> str:
    body = _Body()
    for _ in range(draw.randint(1, 3)):
        _positive(draw, body, same)
    while len(body.names) < 1 or (len(body.numbers) < 1 and "d" in shape):
        _positive(draw, body, {"w": "nd"} if body.names else {"w": "nd", "e": "nn"}, own=True)
    for _ in range(draw.randint(0, 2)):
        choice = draw.randint(0, 2)
        if choice == 0:
            body.goals.append(_comparison(draw, body.names, body.numbers))
        else:
            body.goals.append(_denial(draw, body, lower, choice == 2))
    args = [draw.choice(body.names if kind == "n" else body.numbers) for kind in shape]
    if draw.randint(0, 9) == 0:
        at = shape.index("n")
        args[at] = draw.choice(NAMES)
    return f"{head}({', '.join(args)}) :- {', '.join(body.goals)}."


def _positive(draw: Random, body: _Body, same: dict[str, str], own: bool = False) -> None:
    pool = same if own else {**same, **same, **FACTS, **(THEORY if draw.random() < 0.5 else {})}
    name = draw.choice(sorted(pool))
    text, names, numbers = body.atom(draw, name, pool[name])
    body.goals.append(text)
    body.names += names
    body.numbers += numbers


def _comparison(draw: Random, names: list[str], numbers: list[str]) -> str:
    if numbers and draw.randint(0, 3):
        operator = draw.choice(["<", "=<", ">", ">=", "=:=", "=\\="])
        left = draw.choice(numbers)
        right = draw.choice([*NUMBERS, *numbers, f"{left} + 0.5", f"-{numbers[0]} - 1", "2 - 0.5"])
        return f"{left} {operator} {right}"
    operator = draw.choice(["==", "\\==", "=", "\\=", "\\=="])
    return f"{draw.choice(names)} {operator} {draw.choice([*names, *NAMES])}"


def _denial(draw: Random, body: _Body, lower: dict[str, str], long: bool) -> str:
    pool = {**lower, **FACTS, **(THEORY if draw.randint(0, 3) == 0 else {})}
    goals, names, numbers = [], list(body.names), list(body.numbers)
    for _ in range(draw.randint(1, 2) if long else 1):
        name = draw.choice(sorted(pool))
        text, more, measured = body.atom(draw, name, pool[name], names)
        goals.append(text)
        names += more
        numbers += measured
    if long and draw.random() < 0.5:
        goals.append(_comparison(draw, names, numbers))
    return f"\\+ {goals[0]}" if len(goals) == 1 else f"\\+ ( {', '.join(goals)} )"
