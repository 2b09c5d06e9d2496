#!/usr/bin/env bash
# The tag in the argument, such as v0.1.0, is that of the version in Cargo.toml.
set -euo pipefail
cd "$(dirname "$0")/.."
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"$/\1/p' Cargo.toml)
if [ "$1" != "v$version" ]; then
    echo "the tag is $1, the version in Cargo.toml $version: set the one to the other" >&2
    exit 1
fi
