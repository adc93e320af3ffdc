#!/bin/sh
# Usage: sh .ci/setup.sh REQUIREMENTS
# Brings a machine that has only Python 3.11+ to where Deixis runs: SWI-Prolog, .venv, the pinned
# REQUIREMENTS, and this checkout installed in it. Does nothing that is done already. PYTHON chooses the interpreter.
# With POSTGIS=install also PostgreSQL with PostGIS, which some tests compare with and skip without; with
# JAVA=install also a Java runtime, for those that ask an OWL reasoner; with BROWSER=install also Chromium, for
# those of the query page.
set -eu
requirements=$1
python=.venv/bin/python
log=$(mktemp)
trap 'rm -f "$log"' EXIT

say() { printf '%s\n' "$*" >&2; }

# apt_install PACKAGE: sets apt_said to what happened; fails where apt, or the right to use it, is missing.
apt_install() {
    if ! command -v apt-get >/dev/null 2>&1; then
        apt_said="there is no apt-get here"
        return 1
    elif [ "$(id -u)" -eq 0 ]; then
        as_root=
    elif sudo -n true >/dev/null 2>&1; then
        as_root="sudo -n"
    else
        apt_said="not allowed: neither root nor sudo without a password"
        return 1
    fi
    say "Installing $1 ..."
    # An update that fails for one unrelated archive must not stop an install that can succeed.
    for step in update "install -y --no-install-recommends $1"; do
        # shellcheck disable=SC2086
        if $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300 $step \
            </dev/null >"$log" 2>&1; then apt_said="installed $1"; else apt_said="apt-get $step failed"; fi
    done
    case $apt_said in *failed) tail -n 5 "$log" >&2; return 1 ;; esac
}

supported() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; }

find_python() {
    for candidate in ${PYTHON:-python3 python3.13 python3.12 python3.11}; do
        if supported "$candidate"; then
            printf '%s\n' "$candidate"
            return
        fi
    done
    say "Python 3.11 or newer is needed; tried: ${PYTHON:-python3 python3.13 python3.12 python3.11}."
    say "Install it, or name it: make PYTHON=/path/to/python3.12 ..."
    return 1
}

make_venv() {
    base=$(find_python)
    rm -rf .venv
    if command -v uv >/dev/null 2>&1; then
        uv venv --quiet --python "$base" .venv
        return
    fi
    if ! "$base" -c 'import ensurepip, venv' >/dev/null 2>&1; then
        package=$("$base" -c 'import sys; print("python3.%d-venv" % sys.version_info[1])')
        if ! apt_install "$package"; then
            say "$base cannot make virtual environments (its venv module is missing); apt-get: $apt_said."
            say "Install it:  sudo apt install $package     or install uv."
            return 1
        fi
    fi
    "$base" -m venv .venv
}

pip_install() {
    if command -v uv >/dev/null 2>&1; then
        uv pip install --quiet --python "$python" "$@"
    else
        # Python compiles what is imported when it is; compiling all that is installed takes longer than installing.
        "$python" -m pip --quiet --quiet --disable-pip-version-check install --no-compile "$@"
    fi
}

swipl_version() { swipl --version 2>/dev/null | sed -n 's/^SWI-Prolog version \([0-9.]*\).*/\1/p'; }

new_enough() { found=$(swipl_version) && [ "${found%%.*}" -ge 9 ] 2>/dev/null; }

if ! new_enough; then
    before=${found:-not found}
    if apt_install swi-prolog-nox; then
        new_enough || apt_said="$apt_said, which is ${found:-not on the PATH}"
    fi
    if ! new_enough; then
        say "Deixis needs SWI-Prolog 9 or newer."
        say "  tried  swipl on the PATH               $before"
        say "  tried  apt-get install swi-prolog-nox  $apt_said"
        say "Install it with the one of these that fits, then run make again:"
        say "  Debian, Ubuntu  sudo apt install swi-prolog-nox"
        say "  conda           conda install -c conda-forge swi-prolog"
        say "  macOS           brew install swi-prolog"
        exit 1
    fi
fi
if [ "${POSTGIS:-}" = install ] && ! ls /usr/share/postgresql/*/extension/postgis_sfcgal.control >/dev/null 2>&1; then
    apt_install postgresql-postgis || say "PostGIS: $apt_said. The tests that compare with it are skipped."
fi
if [ "${JAVA:-}" = install ] && ! command -v java >/dev/null 2>&1; then
    apt_install default-jre-headless || say "Java: $apt_said. The tests that ask an OWL reasoner are skipped."
fi
if [ "${BROWSER:-}" = install ] && ! command -v chromium >/dev/null 2>&1 && ! command -v chromium-browser >/dev/null 2>&1; then
    apt_install chromium || say "Chromium: $apt_said. The tests of the query page in a browser are skipped."
fi
supported "$python" || make_venv
say "Installing $requirements into .venv ..."
pip_install --require-hashes -r "$requirements"
pip_install --no-deps --no-build-isolation --editable .
