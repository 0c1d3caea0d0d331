#!/usr/bin/env bash
# First half of the set-up: find Python 3.11 or newer (as root on Debian or Ubuntu: install it), then hand
# over to setup_env.py. Usage: tools/setup.sh run|test
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

is_new_enough() {
    command -v "$1" >/dev/null && "$1" -c 'import ctypes, sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null
}

find_python() {
    local name
    for name in python3 python3.11 python3.12 python3.13 python3.14; do
        if is_new_enough "$name"; then
            echo "$name"
            return
        fi
    done
    return 1
}

if ! python=$(find_python) && [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    echo "Installing python3 with apt-get" >&2
    export DEBIAN_FRONTEND=noninteractive
    apt-get -qq update >/dev/null || true
    apt-get -qq -y install --no-install-recommends python3 python3-venv >/dev/null || true
fi
if ! python=$(find_python); then
    echo "RigLens needs Python 3.11 or newer; install it with: sudo apt-get install -y python3 python3-venv" \
        "(where python3 is older: python3.11 python3.11-venv)" >&2
    exit 2
fi
exec "$python" tools/setup_env.py "$@"
