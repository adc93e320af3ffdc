"""What a wheel holds, that it works away from the checkout, and that what it needs is pinned."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest

import deixis
from deixis import _files
from deixis.errors import RuleError

# One wheel for all of these: built once, in one worker.
pytestmark = pytest.mark.xdist_group("packaging")

REQUIREMENTS = ("requirements.txt", "requirements-dev.txt")


def run(*command: str | Path, cwd: Path) -> str:
    """Run a command without the caller's Python settings and return what it prints."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    result = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


@pytest.fixture(scope="module")
def wheel(root: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build the source archive, and from that alone the wheel."""
    out = tmp_path_factory.mktemp("dist")
    run(sys.executable, "-m", "build", "--no-isolation", "--outdir", out, root, cwd=out)
    return next(out.glob("*.whl"))


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Install the wheel in a fresh environment, which borrows only its dependencies from this one."""
    home = tmp_path_factory.mktemp("fresh")
    run(sys.executable, "-m", "venv", "--without-pip", home, cwd=home)
    site = next(home.glob("lib/python3*/site-packages"))
    # A path added this way brings in no .pth of its own: the checkout's editable install stays out of sight.
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    run(home / "bin" / "python", "-m", "installer", wheel, cwd=home)
    return home


def names(top: Path) -> set[str]:
    """Return the files of a directory as the wheel names them."""
    return {f"deixis/{path.relative_to(top.parent).as_posix()}" for path in top.rglob("*") if path.is_file()}


def test_wheel_holds_all_rules_and_all_knowledge(root: Path, wheel: Path) -> None:
    packed = set(zipfile.ZipFile(wheel).namelist())
    assert {n for n in packed if n.startswith("deixis/rules/")} == names(root / "rules") != set()
    assert {n for n in packed if n.startswith("deixis/kb/")} == names(root / "kb") != set()
    source = root / "src" / "deixis"
    sql = {f"deixis/{path.relative_to(source).as_posix()}" for path in source.rglob("*.sql")}
    assert {n for n in packed if n.endswith(".sql")} == sql != set()
    assert "deixis/py.typed" in packed
    assert f"deixis-{deixis.__version__}.dist-info/licenses/LICENSE" in packed


def test_wheel_holds_the_pages_that_were_built(root: Path, wheel: Path) -> None:
    packed = set(zipfile.ZipFile(wheel).namelist())
    for page in ("server", "view"):
        folder = root / "src" / "deixis" / page / "page"
        assert {f"deixis/{page}/page/{one.name}" for one in folder.iterdir() if one.is_file()} <= packed
        built = {f"deixis/{page}/page/vendor/{one.name}" for one in folder.glob("vendor/*")}
        assert built <= packed
        assert not built or f"deixis/{page}/page/vendor/LICENSES.txt" in built


def test_installed_package_reads_its_own_files(installed: Path, tmp_path: Path) -> None:
    ask = "from deixis import _files; print(_files.rules_dir()); print(_files.kb_dir())"
    places = run(installed / "bin" / "python", "-I", "-c", ask, cwd=tmp_path).splitlines()
    site = next(installed.resolve().glob("lib/python3*/site-packages"))
    assert places == [str(site / "deixis" / "rules"), str(site / "deixis" / "kb")]


def test_installed_demo_runs_from_another_directory(installed: Path, tmp_path: Path) -> None:
    assert "affixed on" in run(installed / "bin" / "deixis", "demo", cwd=tmp_path)


def test_installed_rule_files_are_found_by_name(installed: Path, tmp_path: Path) -> None:
    scene = (
        next(installed.resolve().glob("lib/python3*/site-packages"))
        / "deixis"
        / "kb"
        / "scenes"
        / "kitchen.json"
    )
    told = run(installed / "bin" / "deixis", "check", scene, "--rules", "safety", cwd=tmp_path)
    assert told == "5 rules checked on 77 things: no violation\n"


def test_checkout_reads_its_own_files(root: Path) -> None:
    assert (_files.rules_dir(), _files.kb_dir()) == (root / "rules", root / "kb")


def test_missing_files_name_both_places(tmp_path: Path) -> None:
    package = tmp_path / "lib" / "site-packages" / "deixis"
    with pytest.raises(RuleError) as error:
        _files._find("rules", package)
    assert str(package / "rules") in str(error.value)
    assert str(tmp_path / "lib" / "rules") in str(error.value)


def pins(path: Path) -> dict[str, str]:
    """Return the version each distribution is pinned to."""
    return dict(re.findall(r"^([a-z0-9-]+)==(\S+)", path.read_text(encoding="utf-8"), flags=re.MULTILINE))


@pytest.mark.parametrize("name", REQUIREMENTS)
def test_requirements_are_hashed_and_name_no_host(root: Path, name: str) -> None:
    text = (root / name).read_text(encoding="utf-8")
    entries = [line for line in text.replace("\\\n", "").splitlines() if not line.lstrip().startswith("#")]
    pinned = re.compile(r"[a-z0-9-]+==[^ ]+( ; [^-]+)?( +--hash=sha256:[0-9a-f]{64})+")
    assert [entry for entry in entries if not pinned.fullmatch(entry)] == []
    assert "://" not in text


def test_requirements_agree_with_the_project_and_each_other(root: Path) -> None:
    runtime, dev = (pins(root / name) for name in REQUIREMENTS)
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    wanted = {re.match(r"[a-z0-9-]+", need)[0] for need in project["project"]["dependencies"]}
    assert wanted <= runtime.keys()
    assert runtime.items() <= dev.items()
