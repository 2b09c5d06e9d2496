#!/usr/bin/env bash
# Makes the figures of docs/getting_started.md anew with the commands shown there.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
cargo build --release --locked --bin bracketry --manifest-path "$root/Cargo.toml"
bracketry=${CARGO_TARGET_DIR:-$root/target}/release/bracketry
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cp "$root"/docs/getting_started/*.toml "$folder" && cd "$folder"
"$bracketry" simulate ball.toml --scenario ball_scenario.toml --out simulated
"$bracketry" control ball_problem.toml --out controlled
"$bracketry" simulate felt.toml --scenario ball_scenario.toml --noise position=0.0005,angle=0.0002 --seed 1 --out data
"$bracketry" diagnose ball.toml data/measured.csv --hold linear --out diagnosed
cp simulated/trajectory.png "$root/docs/figures/getting_started_trajectory.png"
cp controlled/closed_loop.png "$root/docs/figures/getting_started_closed_loop.png"
cp diagnosed/prediction.png "$root/docs/figures/getting_started_prediction.png"
