#!/usr/bin/env bash
# The wheel and the source distribution in dist/, their metadata checked, and both tried in a clean environment: the package,
# the command, and the module as a command.
set -euo pipefail
cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-$PWD/target}
tools=$target/packaging-environment
clean=$(mktemp -d)
bin=bin
case $(uname -s) in
    MINGW* | MSYS* | CYGWIN*) bin=Scripts ;;
esac
licenses=$PWD/crates/python/python/bracketry/THIRDPARTY.txt   # in the package, so that the wheel has it
trap 'rm -rf "$clean" "$licenses"' EXIT
test -d "$tools/$bin" || python3 -m venv "$tools"
"$tools/$bin/python" -m pip install --quiet --disable-pip-version-check --requirement packaging/requirements.txt
rm -f dist/*.whl dist/*.tar.gz
packaging/licenses.py bracketry-python "$licenses"
"$tools/$bin/maturin" build --release --locked --out dist
rm "$licenses"
"$tools/$bin/maturin" sdist --out dist
"$tools/$bin/twine" check --strict dist/*.whl dist/*.tar.gz
packaging/try_wheel.sh
# The source distribution is what a system without a wheel builds.
source=$(ls "$PWD"/dist/*.tar.gz)
python3 -m venv "$clean"
# From nothing: a folder with other builds would be taken as up to date.
env -u CARGO_TARGET_DIR "$clean/$bin/python" -m pip install --quiet --disable-pip-version-check "$source"
cd "$clean"   # away from the sources
"$bin/bracketry" new mass >/dev/null
"$bin/bracketry" analyze mass.toml >/dev/null
echo "installed from its source distribution: the command runs"
