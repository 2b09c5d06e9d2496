#!/usr/bin/env bash
# What a release publishes, without publishing it: every crate is packaged and built from its package, in the order of their
# dependencies, which is printed; the program, the wheel, and the source distribution are made, checked, and tried where nothing else is installed.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo publish --workspace --dry-run --locked "$@"
packaging/publish.sh --list
packaging/program.sh
packaging/wheel.sh
