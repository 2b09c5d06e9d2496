#!/usr/bin/env bash
# The Python package as a user gets it: installed from the repository into an environment of its own, then its types, its tests
# and its notebooks. The environment is kept under target/; the first argument is the profile of cargo that the wheel is built in
# (dev if left out: with the workspace's settings it is fast enough, and builds in half the time of release).
set -euo pipefail
cd "$(dirname "$0")/../.."
profile=${1:-dev}
target=${CARGO_TARGET_DIR:-$PWD/target}
environment=$target/python-environment
python=$environment/bin/python
if [ ! -x "$python" ]; then
    python3 -m venv "$environment"
fi
"$python" -m pip install --quiet --disable-pip-version-check --requirement crates/python/requirements-ci.txt
# The wheel is built by the maturin of the environment, so that nothing but what is pinned takes part.
PATH=$environment/bin:$PATH CARGO_TARGET_DIR=$target MATURIN_PEP517_ARGS="--profile $profile --features native" \
    "$python" -m pip install --quiet --disable-pip-version-check --no-build-isolation --no-deps --force-reinstall .
"$python" -m mypy
"$python" -m mypy.stubtest bracketry._native --mypy-config-file pyproject.toml
"$python" -m pytest --quiet crates/python/tests
"$python" -m pytest --quiet --nbmake --nbmake-timeout=120 notebooks
