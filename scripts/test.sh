#!/usr/bin/env bash
# Builds and runs all tests, optimised and then, but for the longest walks through recorded data, under the address and
# undefined-behaviour sanitizers.
#
# Environment:
#   ARBORSLAM_DATA=DIR     recorded data; tests that need data which is absent are skipped.
#   ARBORSLAM_SKIP_ASAN=1  leave out the run under the sanitizers.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
readonly root
if [[ -n "${ARBORSLAM_DATA:-}" ]]; then
  # Tests run in a folder of their own.
  ARBORSLAM_DATA="$(realpath "${ARBORSLAM_DATA}")"
  export ARBORSLAM_DATA
fi
cd "${root}"

scripts/install_packages.sh

presets=(release asan)
if [[ "${ARBORSLAM_SKIP_ASAN:-0}" == "1" ]]; then
  presets=(release)
fi
for preset in "${presets[@]}"; do
  echo "== ${preset}"
  cmake --preset "${preset}"
  cmake --build --preset "${preset}" --parallel "$(nproc)"
  # No tests at all means that the build left them out.
  ctest --preset "${preset}" --parallel "$(nproc)" --no-tests=error
done
