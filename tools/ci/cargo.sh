#!/usr/bin/env bash
# Checks that cargo is there and new enough: the rust-version of the workspace. Prints the folder of cargo, to put on PATH.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
wanted=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' "$root/Cargo.toml")
PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin

if ! command -v cargo >/dev/null; then
    echo "cargo: not found; expected Rust $wanted or newer: install it from https://rustup.rs and start again" >&2
    exit 1
fi
found=$(cd "$root" && cargo --version | cut -d' ' -f2)
if [ "$(printf '%s\n%s\n' "$wanted" "$found" | sort -V | head -n1)" != "$wanted" ]; then
    echo "cargo: found version $found, expected $wanted or newer: update it with 'rustup update' and start again" >&2
    exit 1
fi
dirname "$(command -v cargo)"
