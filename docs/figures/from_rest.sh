#!/usr/bin/env bash
# Regenerates the figures of docs/from_rest.md and of "From rest to rest" in docs/plate.md, with the commands shown there.
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
cargo build --release --locked --bin bracketry --manifest-path "$root/Cargo.toml"
bracketry=${CARGO_TARGET_DIR:-$root/target}/release/bracketry
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# A figure, the model, the bounds or - where the model's ranges do, and the map or - where there is none.
figure() {
    local options=(--from-rest --time-limit 600 --out "$folder/$1")
    test "$3" = - || options+=(--bounds "$3")
    test "$4" = - || options+=(--map "$4")
    "$bracketry" analyze "$root/models/$2.toml" "${options[@]}" >/dev/null
    cp "$folder/$1/$5" "$root/docs/figures/$1.png"
}
figure bowl_from_rest vibrating_bowl - "der(X,2)=1..5,der(Y,2)=1..5" from_rest_map.png
figure beam_from_rest cart_on_tilting_beam - "theta=0.05..0.4,der(theta,2)=1..20" from_rest_map.png
figure plate_from_rest plate_published "der(theta,2)=-20..20" "der(X,2)=1..5,theta=0.1..0.5" from_rest_map.png
figure plate_from_rest_footprint plate_reduced "der(theta,2)=-20..20" "der(X,2)=1..5,theta=0.1..0.5" from_rest_map.png
figure plate_displacements plate_reduced "der(X,2)=-5..5,theta=-0.4..0.4,der(theta,2)=-20..20" - displacements_x_phi.png
