"""Modules import only downwards, the contract that says so can fail, and the guide draws the same layers."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

MOST_LINES = 400


def lint_imports(root: Path, source: Path) -> subprocess.CompletedProcess[str]:
    """Check the package ``source/deixis`` against the contracts of pyproject.toml."""
    return subprocess.run(
        [
            Path(sys.executable).with_name("lint-imports"),
            "--no-cache",
            "--no-logo",
            f"--config={root / 'pyproject.toml'}",
        ],
        env=os.environ | {"PYTHONPATH": str(source), "COLUMNS": "200"},
        cwd=root,
        capture_output=True,
        text=True,
        check=False,
    )


def layers(root: Path) -> list[list[str]]:
    """Return the contract's layers, top first, without the modules that are still to come."""
    config = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    contract = next(c for c in config["tool"]["importlinter"]["contracts"] if c["id"] == "layers")
    package = root / "src" / "deixis"
    rows = [[name.strip(" ()") for name in row.split("|")] for row in contract["layers"]]
    present = [[n for n in row if (package / n).is_dir() or (package / f"{n}.py").is_file()] for row in rows]
    return [row for row in present if row]


def test_modules_import_only_downwards(root: Path) -> None:
    result = lint_imports(root, root / "src")
    assert result.returncode == 0, result.stdout + result.stderr


@pytest.mark.parametrize(
    ("module", "line", "broken"),
    [
        ("errors.py", "import deixis.thresholds", "deixis.errors -> deixis.thresholds"),
        ("frames.py", "import pyswip", "deixis.frames -> pyswip"),
        ("stray.py", "", "stray"),
    ],
)
def test_a_wrong_import_breaks_the_contracts(
    root: Path, tmp_path: Path, module: str, line: str, broken: str
) -> None:
    package = shutil.copytree(root / "src" / "deixis", tmp_path / "deixis")
    with (package / module).open("a", encoding="utf-8") as file:
        file.write(f"\n{line}\n")
    result = lint_imports(root, tmp_path)
    assert result.returncode == 1, result.stdout + result.stderr
    assert broken in result.stdout


def test_the_guide_draws_the_layers(root: Path) -> None:
    """A fenced block of architecture.md has a line for each layer: names, then perhaps words."""
    blocks = (root / "kb" / "guide" / "architecture.md").read_text(encoding="utf-8").split("```")[1::2]
    drawings = [
        [[name.strip() for name in line.split("  ")[0].split("|")] for line in block.splitlines()[1:] if line]
        for block in blocks
    ]
    public = [[name for name in row if not name.startswith("_")] for row in layers(root)]
    assert public in drawings


def test_a_module_fits_in_one_sitting(root: Path) -> None:
    sizes = {
        path.relative_to(root).as_posix(): len(path.read_text(encoding="utf-8").splitlines())
        for path in (root / "src").rglob("*.py")
    }
    assert {name: size for name, size in sizes.items() if size > MOST_LINES} == {}
