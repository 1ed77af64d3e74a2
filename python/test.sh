#!/bin/sh
# Makes a virtual environment, builds the package, installs it there, and runs its style checks, its tests, the examples of docs/python.md and the notebooks.
# Arguments go to pytest. BLESS=1 python/test.sh -k notebooks draws the pictures of that page anew.
set -eu

self=$(readlink -f -- "$0")
folder=${self%/*}
environment=${BHS_PYTHON_VENV:-$folder/../target/python-venv}

cd -- "$folder"
[ -x "$environment/bin/python" ] || python3 -m venv "$environment"
# One wheel, built once: pip builds a folder anew each time that it is asked for it.
wheels=$(mktemp -d)
trap 'rm -rf "$wheels"' EXIT
"$environment/bin/pip" wheel --quiet --disable-pip-version-check --no-deps --wheel-dir "$wheels" .
"$environment/bin/pip" install --quiet --disable-pip-version-check "$(echo "$wheels"/bhs-*.whl)[test]"
"$environment/bin/pip" install --quiet --disable-pip-version-check --force-reinstall --no-deps "$wheels"/bhs-*.whl

CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$folder/../target}
export CARGO_TARGET_DIR
cargo fmt --check
cargo clippy --release --all-targets -- -D warnings
"$environment/bin/pytest" tests "$@"
