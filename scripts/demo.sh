#!/usr/bin/env bash
# Builds the programs, simulates an orchard, maps it, and compares the trajectory with the exact one.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
readonly root
readonly bin="build/release/bin"
readonly orchard="demo_output/orchard"
readonly slam="demo_output/slam"
cd "${root}"

scripts/install_packages.sh
cmake --preset release > /dev/null
cmake --build --preset release --parallel "$(nproc)" --target arborslam_simulate arborslam_offline arborslam_evaluate

rm -rf demo_output
mkdir -p demo_output
echo "== Simulating an orchard: a legged robot with a VLP-16, followed by people"
"${bin}/arborslam_simulate" --scenario orchard --seed 1 --scans 800 --output "${orchard}"
echo "== Mapping it"
"${bin}/arborslam_offline" --input "${orchard}" --output "${slam}" --ground_truth "${orchard}/ground_truth.tum"
echo "== Comparing with the ground truth"
"${bin}/arborslam_evaluate" --reference "${orchard}/ground_truth.tum" --estimate "${slam}/trajectory.tum" \
  --plot demo_output/trajectory.png

cat << EOT

Done. See in ${root}:
  ${slam}/report.html         the run: map, errors, scores, times; open it in a browser
  ${slam}/map.png             the map
  ${slam}/cloud.ply           the 3D map, for CloudCompare or MeshLab
  demo_output/trajectory.png  the estimated and the true trajectory
  ${slam}/summary.json        counts, times and errors
EOT
