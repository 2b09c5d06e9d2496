#!/usr/bin/env bash
# The tag in the argument, such as v0.1.0, is the version in Cargo.toml, the citation, the conda recipe, the changelog, and the links of the
# texts for registries.
set -euo pipefail
cd "$(dirname "$0")/.."
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"$/\1/p' Cargo.toml)
if [ "$1" != "v$version" ]; then
    echo "the tag is $1, the version in Cargo.toml $version: make them equal" >&2
    exit 1
fi
has() {
    if ! grep -q -x -- "$2" "$1"; then
        echo "$1: no line \`$2\`: set its version to that of the tag" >&2
        exit 1
    fi
}
escaped=${version//./\\.}
has CITATION.cff "version: $escaped"
has CITATION.cff "date-released: [0-9-]*"
has packaging/conda/recipe.yaml "  version: \"$escaped\""
has CHANGELOG.md "## \[$escaped\] - [0-9-]*"
for text in crates/README.md crates/python/README.md; do
    if grep -o "/blob/[^/]*/" "$text" | grep -v -x "/blob/v$escaped/" >&2; then
        echo "$text: links to documents of another version than v$version" >&2
        exit 1
    fi
done
