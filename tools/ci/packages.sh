#!/usr/bin/env bash
# Installs the system packages that Terrane needs and that are missing (Debian, Ubuntu and their kin).
# Usage: packages.sh run|test|browsers. Quick, and says nothing, when nothing is missing.
set -euo pipefail

purpose=${1:-run}

# A package a line, and what for.
needed() {
    if [ "$purpose" = browsers ]; then
        # By command: Node from elsewhere than the distribution brings an npm that its package would break.
        command -v chromium >/dev/null || echo "chromium a browser that draws tiles in tests"
        command -v node >/dev/null || echo "nodejs runs the browser in tests, and Khronos's validator"
        command -v npm >/dev/null || echo "npm fetches what the browser runs"
        return
    fi
    echo "libvulkan1 the Vulkan loader"
    echo "mesa-vulkan-drivers Vulkan drivers, and lavapipe where there is no GPU"
    local window="windows (terrane fly)"
    for package in libxkbcommon-x11-0 libx11-6 libxcursor1 libxi6 libxrandr2 libx11-xcb1; do
        echo "$package $window"
    done
    if [ "$purpose" = test ]; then
        echo "vulkan-validationlayers validation, which every test runs under"
        echo "xvfb a display for the tests of windows"
        echo "xdotool key presses for the tests of windows"
        echo "openbox a window manager for the test of windows that fill the screen"
    fi
}

have_compiler() { command -v cc >/dev/null && command -v c++ >/dev/null; }

if ! command -v dpkg-query >/dev/null; then
    # Not a Debian: nothing can be installed for you, and only the compiler can be looked for under one name everywhere.
    if ! have_compiler; then
        echo "packages: no C and C++ compiler (cc, c++) found; install one, for the SQLite and glslang that are built in" >&2
        exit 1
    fi
    exit 0
fi

# The status of all packages in one query; those unknown to dpkg are on its stderr only.
installed=$(needed | cut -d' ' -f1 | xargs dpkg-query -W -f='${db:Status-Abbrev} ${Package}\n' 2>/dev/null | sed -n 's/^ii  *//p' || true)
missing=()
have_compiler || { missing+=(build-essential); echo "packages: build-essential is missing: compiles the SQLite and glslang that are built in" >&2; }
while read -r package reason; do
    if ! grep -qx "$package" <<<"$installed"; then
        missing+=("$package")
        echo "packages: $package is missing: $reason" >&2
    fi
done < <(needed)
[ ${#missing[@]} -gt 0 ] || exit 0

if [ "$(id -u)" = 0 ]; then
    as_root=()
elif command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
    as_root=(sudo -n)
else
    echo "packages: cannot install them without root; please run:" >&2
    echo "    sudo apt-get update && sudo apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
fi

echo "packages: installing ${missing[*]}" >&2
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -y)
if ! { "${apt[@]}" update && "${apt[@]}" install --no-install-recommends "${missing[@]}"; } </dev/null >&2; then
    echo "packages: apt-get failed (its messages are above); please install by hand: ${missing[*]}" >&2
    exit 1
fi
