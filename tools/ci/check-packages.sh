#!/usr/bin/env bash
# Fails unless the packages hold what their users need and nothing else: what `cargo package` would upload, by name.
set -euo pipefail

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
status=0
fail() {
    echo "check-packages: $1: $2" >&2
    status=1
}

# What no package holds: build results, documentation, pictures, films, tests and their data, fuzz targets.
foreign='(^|/)(target|docs|fuzz|tests/(data|pictures)|proptest-regressions)/|\.(planet|png|jpg|jpeg|svg|exr|mp4|webm|profraw|profdata)$'

# The maps that recipes are made of are what their package is for.
maps='^recipes/earth-(topology\.png|blue-marble\.jpg)$'

# A package, and the files that it must hold beside those of all packages.
while read -r package needed; do
    files=$(cargo package --list --allow-dirty --package "$package" 2>/dev/null) || { fail "$package" "cargo package --list failed"; continue; }
    for file in Cargo.toml README.md LICENSE-MIT LICENSE-APACHE $needed; do
        grep -qxF -- "$file" <<<"$files" || fail "$package" "$file is missing"
    done
    while read -r file; do
        fail "$package" "$file does not belong there"
    done < <(grep -E -- "$foreign" <<<"$files" | grep -vE -- "$maps")
done <<PACKAGES
terrane-heightfield $(cd planet/heightfield && git ls-files src | xargs)
terrane-planet $(cd planet && git ls-files src recipes | xargs)
terrane build.rs $(git ls-files src shaders | xargs)
terrane-tools build.rs $(cd tools && git ls-files src paths gallery.toml | xargs)
PACKAGES
exit "$status"
