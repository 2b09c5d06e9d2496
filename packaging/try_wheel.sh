#!/usr/bin/env bash
# The wheel in dist/ is installed into a clean environment and tried: the package, the command, and the module as a command agree.
set -euo pipefail
cd "$(dirname "$0")/.."
clean=$(mktemp -d)
trap 'rm -rf "$clean"' EXIT
python3 -m venv "$clean"
programs=$clean/bin
test -d "$programs" || programs=$clean/Scripts   # Windows
"$programs/python" -m pip install --quiet --disable-pip-version-check dist/*.whl
"$programs/python" -m pip show --files bracketry | grep THIRDPARTY.txt >/dev/null
cd "$clean"   # away from the sources
"$programs/bracketry" --version
"$programs/bracketry" new mass >/dev/null
"$programs/bracketry" analyze mass.toml --json >command.json
"$programs/python" -m bracketry analyze mass.toml --json >module.json
"$programs/python" - "$programs/bracketry" <<'PROGRAM'
import json
import subprocess
import sys

import bracketry

command, module = (json.load(open(name)) for name in ("command.json", "module.json"))
library = bracketry.analyze(bracketry.System.from_file("mass.toml"))
dimensions = [report["modes"][0]["accessible_dimension"] for report in (command, module)]
assert dimensions == [library.modes[0].accessible_dimension] * 2, (dimensions, library)
missing = subprocess.run([sys.argv[1], "analyze", "no_such_file.toml"], capture_output=True)
assert missing.returncode == 2 and b"no_such_file.toml" in missing.stderr, missing
print("bracketry", bracketry.__version__, "installed from its wheel: package, command, and module agree")
PROGRAM
