#!/usr/bin/env bash
# Fails when git tracks what a build or a run makes: anything in a folder `target`, planet files, profiles, films, libraries.
set -euo pipefail

cd "$(git -C "$(dirname "${BASH_SOURCE[0]}")" rev-parse --show-toplevel)"
made='(^|/)target/|\.(planet|planet-(journal|wal|shm)|profraw|profdata|rlib|rmeta|spv|mp4|webm)$|(^|/)out/|(^|/)perf\.data'
if tracked=$(git ls-files | grep -E "$made"); then
    echo "check-tree: results of builds or runs are tracked; git rm --cached them:" >&2
    echo "$tracked" >&2
    exit 1
fi
