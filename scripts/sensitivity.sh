#!/usr/bin/env bash
# Measures how the accuracy depends on the inlier ratio alpha and the cell size, and writes docs/sensitivity.md.
#
# usage: scripts/sensitivity.sh RUN.npz [RUN.npz ...]     (recordings with gnss_rotated_c as reference)
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
readonly root
if [[ $# -eq 0 ]]; then
  echo "usage: scripts/sensitivity.sh RUN.npz [RUN.npz ...]" >&2
  exit 2
fi
readonly program="${root}/build/release/bin/arborslam_offline"
if [[ ! -x "${program}" ]]; then
  echo "sensitivity.sh: ${program} does not exist; build it first: cmake --preset release && cmake --build --preset release" >&2
  exit 1
fi

work="$(mktemp -d)"
trap 'rm -rf "${work}"' EXIT

# ate SECTION: the ATE RMSE of that section of the latest summary's errors.
ate() {
  awk -v section="\"$1\"" '$1 == section ":" { inside = 1 } inside && $1 == "\"ate_se2_rmse_m\":" { printf "%.3f", $2; exit }' \
    "${work}/run/summary.json"
}

{
  echo "# Sensitivity to alpha and cell size"
  echo
  echo "ATE RMSE [m] after SE(2) alignment, \`trajectory.tum\` / \`odometry.tum\`, all other options at their defaults. The"
  echo "default is alpha in [0.7, 0.8] and cells of 5 cm. Made by \`scripts/sensitivity.sh\`."
  for run in "$@"; do
    echo
    echo "## $(basename "${run}" .npz)"
    echo
    echo "| alpha | 2.5 cm | 5 cm | 10 cm |"
    echo "|---|---|---|---|"
    for alpha in "0.6 0.6" "0.65 0.65" "0.7 0.8" "0.85 0.85" "0.9 0.9" "1.0 1.0"; do
      read -r low high <<< "${alpha}"
      label="${low}"
      [[ "${low}" == "${high}" ]] || label="${low}-${high}"
      row="| ${label} |"
      for cell in 0.025 0.05 0.1; do
        "${program}" --input "${run}" --ground_truth "${run}" --output "${work}/run" --quiet \
          --set "mhd.alpha_min=${low}" "mhd.alpha_max=${high}" "grid.cell_size=${cell}"
        row="${row} $(ate trajectory) / $(ate odometry) |"
      done
      echo "${row}"
    done
  done
} > "${work}/sensitivity.md"
mv "${work}/sensitivity.md" "${root}/docs/sensitivity.md"
echo "wrote ${root}/docs/sensitivity.md"
