#!/usr/bin/env bash
# Publishes every crate that the registry does not have in this version, in the order of their dependencies. The registry takes few new
# crates at once: the script waits and goes on. With --list it prints the order and publishes nothing.
set -euo pipefail
cd "$(dirname "$0")/.."
order=$(cargo publish --workspace --dry-run --no-verify --locked 2>&1 | sed -n 's/^ *Uploading \(bracketry[a-z-]*\) v.*/\1/p')
test -n "$order"
if [ "${1:-}" = --list ]; then
    echo "$order"
    exit
fi
for crate in $order; do
    until log=$(cargo publish --locked --no-verify -p "$crate" 2>&1); do
        case $log in
            *"already exists"* | *"already uploaded"*) break ;;
            *429* | *"Too Many Requests"*)
                echo "$crate: the registry limits the rate; waiting for 10 minutes"
                sleep 600
                ;;
            *)
                echo "$log" >&2
                exit 1
                ;;
        esac
    done
    echo "$crate: in the registry"
done
