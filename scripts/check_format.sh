#!/usr/bin/env bash
# Fails if a source file is not formatted as .clang-format asks. To mend: clang-format -i FILE...
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
readonly root
cd "${root}"

if ! command -v clang-format > /dev/null; then
  echo "check_format.sh: no clang-format; run scripts/install_packages.sh" >&2
  exit 1
fi
mapfile -d '' -t files < <(
  find core frontend backend apps tests benchmarks \( -name '*.h' -o -name '*.cc' \) -print0 2> /dev/null | sort -z
)
if [[ ${#files[@]} -eq 0 ]]; then
  echo "check_format.sh: found no source files below ${root}" >&2
  exit 1
fi
clang-format --dry-run -Werror "${files[@]}"
echo "${#files[@]} files are formatted."
