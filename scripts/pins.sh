#!/usr/bin/env bash
# Resolves pyproject.toml into requirements.txt (to run) and requirements-dev.txt (to test): versions and the
# hashes of every file of each, no index address, no comments. UPGRADE=1 takes the newest versions.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"${PYTHON:-python3}" -m venv "$scratch/venv"
"$scratch/venv/bin/python" -m pip install --quiet --disable-pip-version-check "pip-tools>=7.4"

resolve() {  # resolve OUTPUT ARGUMENTS...
    local output=$1
    shift
    cp "$output" "$scratch/$output" 2>/dev/null || true
    "$scratch/venv/bin/python" -m piptools compile --quiet --generate-hashes --allow-unsafe --strip-extras --no-header \
        --no-annotate --no-emit-index-url --no-emit-find-links --no-emit-trusted-host --build-deps-for wheel --build-deps-for editable \
        ${UPGRADE:+--upgrade} --output-file "$scratch/$output" "$@" pyproject.toml
    grep -v -E '^(#|$|--[a-z])' "$scratch/$output" > "$scratch/clean"
    mv "$scratch/clean" "$output"
}

resolve requirements.txt
resolve requirements-dev.txt --extra dev --extra mesh --extra measure --extra studies --extra posterior --extra film --extra serve --extra figures --extra docs --constraint "$PWD/requirements.txt"
echo "Pinned $(grep -c == requirements.txt) packages to run and $(grep -c == requirements-dev.txt) to test."
