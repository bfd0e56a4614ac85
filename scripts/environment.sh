#!/usr/bin/env bash
# Makes, completes or mends the environment in .venv (or $VENV) from the pinned versions.
# Usage: scripts/environment.sh run|test     (PYTHON=... chooses the interpreter, LOWEST=1 the lowest versions allowed)
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

kind=${1:-run}
venv=${VENV:-.venv}
unfinished=$venv/.unfinished
case $kind in
    run) pins=requirements.txt ;;
    test) pins=requirements-dev.txt ;;
    *) echo "scripts/environment.sh: '$kind' is unknown; say run or test" >&2; exit 2 ;;
esac

say() { printf '%s\n' "$*" >&2; }
recent_enough() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; }
version_of() { "$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])'; }
key() { printf '%s %s %s\n' "$(cat requirements.txt "$pins" pyproject.toml scripts/*.sh scripts/lowest_versions.py | cksum)${LOWEST:+ lowest}" "$PWD" "$(version_of "$venv/bin/python")"; }

at_hand() {  # the interpreter itself, or the newest of that name that pyenv keeps without showing it
    local root
    if ! recent_enough "$1" && root=$(pyenv root 2>/dev/null); then
        set -- "$1" "$(find "$root/versions" -path "*/bin/$1" 2>/dev/null | sort -V | tail -n 1)"
        if [ -n "$2" ]; then printf '%s' "$2"; return; fi
    fi
    printf '%s' "$1"
}

choose_python() {
    local candidate
    for candidate in ${PYTHON:-python3 python3.13 python3.12 python3.11}; do
        if recent_enough "$candidate"; then printf '%s' "$candidate"; return; fi
    done
    say "valvetrain needs Python 3.11 or newer, and ${PYTHON:-python3} is not one; install it, or name one with 'make $kind PYTHON=/path/to/python3.11'."
    exit 1
}

make_venv() {
    local python
    python=$(choose_python)
    rm -rf "$venv"
    if ! "$python" -c 'import ensurepip' >/dev/null 2>&1 && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        say "Installing python3-venv, which this Python lacks."
        { apt-get install -y -q python3-venv || { apt-get update -q && apt-get install -y -q python3-venv; }; } >/dev/null 2>&1 || true
    fi
    say "Making the environment $venv with Python $(version_of "$python")."
    if ! "$python" -m venv "$venv"; then
        rm -rf "$venv"
        say "This Python cannot make an environment; install its venv module (Debian: apt-get install python3-venv) and try again."
        exit 1
    fi
}

usable() {
    [ ! -e "$unfinished" ] && recent_enough "$venv/bin/python" && "$venv/bin/python" -m pip --version >/dev/null 2>&1 || return 1
    # An interpreter that was asked for by name must be the one inside.
    [ -z "${PYTHON:-}" ] || [ "$(version_of "$PYTHON" 2>/dev/null)" = "$(version_of "$venv/bin/python")" ]
}

complete() {
    local stamp=$venv/.stamp-$1
    [ -f "$stamp" ] && [ "$(cat "$stamp")" = "$(pins=$2 key)" ]
}

install() {
    local pip=("$venv/bin/python" -m pip --disable-pip-version-check install -qq --no-input --no-compile)
    touch "$unfinished"
    local problems=
    # The pins name every package; without '--no-deps' an old pip looks at newer releases of what a pinned one asks for with an extra, and stops there.
    local what=(--require-hashes --no-deps -r "$pins")
    if [ -n "${LOWEST:-}" ]; then
        "$venv/bin/python" scripts/lowest_versions.py > "$venv/lowest.txt"
        what=(-r "$venv/lowest.txt")
        say "Installing the lowest versions that pyproject.toml allows (a minute or two the first time)."
    else
        say "Installing the versions pinned in $pins (a minute or two the first time)."
    fi
    if ! "${pip[@]}" "${what[@]}" || ! "${pip[@]}" --no-deps --no-build-isolation -e . || ! problems=$("$venv/bin/python" -m pip --disable-pip-version-check check); then
        [ -z "$problems" ] || say "$problems"
        say "The environment could not be installed (see above); mend the cause, often the network, and repeat 'make $kind'."
        exit 1
    fi
    # Bytecode on all cores at once (pip takes one, and half a minute), of the package too; tests of other packages, a quarter of all, and what
    # is no Python of this version are left.
    "$venv/bin/python" -m compileall -qq -j 0 -x '/tests?/' "$venv/lib" src || true
    key > "$venv/.stamp-$kind"
    if [ "$kind" = test ]; then (pins=requirements.txt; key) > "$venv/.stamp-run"; fi
    rm -f "$unfinished"
}

# Two commands started at once must not install over each other.
if command -v flock >/dev/null; then exec 9<pyproject.toml; flock 9; fi

if [ -n "${PYTHON:-}" ]; then PYTHON=$(at_hand "$PYTHON"); fi
if ! usable; then make_venv; fi
if complete "$kind" "$pins"; then exit 0; fi
install
