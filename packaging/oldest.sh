#!/usr/bin/env bash
# The oldest versions that the manifests name work: the Rust of Cargo.toml, the Python that runs this, the NumPy of pyproject.toml.
set -euo pipefail
cd "$(dirname "$0")/.."
rust=$(sed -n 's/^rust-version = "\(.*\)"$/\1/p' Cargo.toml)
numpy=$(sed -n 's/^dependencies = \["numpy>=\(.*\)"\]$/\1/p' pyproject.toml)
target=${CARGO_TARGET_DIR:-$PWD/target}
environment=$target/oldest-environment
rm -rf "$environment"
python3 -m venv "$environment"
"$environment/bin/python" -m pip install --quiet --disable-pip-version-check --requirement packaging/requirements.txt "numpy==$numpy.*" pytest
if command -v rustup >/dev/null && ! rustup run "$rust" rustc --version >/dev/null 2>&1; then
    rustup toolchain install "$rust" --profile minimal
fi
RUSTUP_TOOLCHAIN=$rust PATH=$environment/bin:$PATH "$environment/bin/python" -m pip install --quiet --disable-pip-version-check \
    --no-build-isolation --no-deps --force-reinstall .
"$environment/bin/python" -c "import numpy, sys; print('Python', sys.version.split()[0], 'NumPy', numpy.__version__)"
"$environment/bin/python" -m pytest --quiet crates/python/tests/test_system.py crates/python/tests/test_analysis.py \
    crates/python/tests/test_simulation.py crates/python/tests/test_control.py
