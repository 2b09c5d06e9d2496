#!/usr/bin/env bash
# The wheel and the source distribution in dist/, their metadata checked, and both tried in a clean environment: the package,
# the command, and the module as a command.
set -euo pipefail
cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-$PWD/target}
tools=$target/packaging-environment
clean=$(mktemp -d)
trap 'rm -rf "$clean"' EXIT
test -x "$tools/bin/python" || python3 -m venv "$tools"
"$tools/bin/python" -m pip install --quiet --disable-pip-version-check --requirement packaging/requirements.txt
rm -f dist/*.whl dist/*.tar.gz
"$tools/bin/maturin" build --release --locked --out dist
"$tools/bin/maturin" sdist --out dist
"$tools/bin/twine" check --strict dist/*.whl dist/*.tar.gz
python3 -m venv "$clean"
"$clean/bin/python" -m pip install --quiet --disable-pip-version-check dist/*.whl
cd "$clean"   # away from the sources
bin/bracketry --version
bin/bracketry new mass >/dev/null
bin/bracketry analyze mass.toml --json >command.json
bin/python -m bracketry analyze mass.toml --json >module.json
bin/python - <<'PROGRAM'
import json
import subprocess

import bracketry

command, module = (json.load(open(name)) for name in ("command.json", "module.json"))
library = bracketry.analyze(bracketry.System.from_file("mass.toml"))
dimensions = [report["modes"][0]["accessible_dimension"] for report in (command, module)]
assert dimensions == [library.modes[0].accessible_dimension] * 2, (dimensions, library)
missing = subprocess.run(["bin/bracketry", "analyze", "no_such_file.toml"], capture_output=True)
assert missing.returncode == 2 and b"no_such_file.toml" in missing.stderr, missing
print("bracketry", bracketry.__version__, "installed from its wheel: package, command, and module agree")
PROGRAM
# The source distribution is what a system without a wheel builds.
cd - >/dev/null
source=$(ls "$PWD"/dist/*.tar.gz)
"$clean/bin/python" -m pip uninstall --quiet --yes bracketry
# From nothing: a folder with other builds would be taken as up to date.
env -u CARGO_TARGET_DIR "$clean/bin/python" -m pip install --quiet --disable-pip-version-check "$source"
cd "$clean"
bin/bracketry analyze mass.toml >/dev/null
echo "installed from its source distribution: the command runs"
