#!/usr/bin/env bash
# Programs outside Python that some tests use: a browser for the report page, an independent finite-element code.
# As root on Debian they are installed; elsewhere this says what is missing, and the tests that need it are skipped
# (under CI=true tests/architecture/test_system_parts.py fails instead).
set -uo pipefail

parts=("chromium chromium-browser google-chrome|chromium|the tests that open the report page"
       "ccx ccx_2.20 ccx_2.21|calculix-ccx|the comparison with solid finite elements")

found() { local name; for name in $1; do command -v "$name" >/dev/null 2>&1 && return 0; done; return 1; }

for part in "${parts[@]}"; do
    IFS='|' read -r programs package purpose <<<"$part"
    found "$programs" && continue
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
        echo "Installing $package from Debian for $purpose." >&2
        export DEBIAN_FRONTEND=noninteractive
        apt-get install -y -q --no-install-recommends "$package" >/dev/null 2>&1 \
            || { apt-get update -q >/dev/null 2>&1 && apt-get install -y -q --no-install-recommends "$package" >/dev/null 2>&1; }
    fi
    found "$programs" || echo "$package is not installed and cannot be installed from here; without it are left out: $purpose." >&2
done
exit 0
