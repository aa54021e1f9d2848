#!/usr/bin/env bash
# Measures time and memory of graphs of up to 100,000 keyframes, and writes docs/scaling.md and docs/images/scaling.png.
#
# usage: scripts/scaling.sh     (after building the target arborslam_benchmarks; needs gnuplot)
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
readonly root
readonly program="${root}/build/release/bin/arborslam_benchmarks"
if [[ ! -x "${program}" ]]; then
  echo "scaling.sh: ${program} does not exist; build it first: cmake --preset release && cmake --build --preset release --target arborslam_benchmarks" >&2
  exit 1
fi
if ! command -v gnuplot > /dev/null; then
  echo "scaling.sh: gnuplot is not installed; install the Debian package gnuplot-nox" >&2
  exit 1
fi

work="$(mktemp -d)"
trap 'rm -rf "${work}"' EXIT
# One file each: their counters differ, and a CSV file has one set of columns.
"${program}" --benchmark_filter='OrchardGraph' --benchmark_format=csv > "${work}/graphs.csv"
"${program}" --benchmark_filter='KeyframeOfALongRun' --benchmark_format=csv > "${work}/keyframes.csv"

# Columns by their names: keyframes, edges, loops, seconds, MiB, errors before and after.
awk -F, '
  /^name,/ { for (i = 1; i <= NF; ++i) { gsub(/"/, "", $i); column[$i] = i } }
  /BM_OrchardGraph/ {
    split($1, parts, "/")
    print parts[2], $column["edges"], $column["loops"], $column["cpu_time"] / 1000, $column["peak_mib"],
          $column["before_m"], $column["after_m"]
  }' "${work}/graphs.csv" > "${work}/graphs.txt"

gnuplot << END
set terminal pngcairo size 900,500
set output '${work}/scaling.png'
set logscale xy
set xlabel 'keyframes'
set ylabel 'processor time [s]'
set y2label 'peak memory [MiB]'
set logscale y2
set ytics nomirror
set y2tics
set key left top
set grid
plot '${work}/graphs.txt' using 1:4 with linespoints title 'time', \
     '' using 1:5 axes x1y2 with linespoints title 'memory'
END
mv "${work}/scaling.png" "${root}/docs/images/scaling.png"

{
  echo "# Time and memory over the length of a run"
  echo
  echo "Graphs of rows driven back and forth (\`core/simulation/orchard_graph.h\`): motion, matches to two active submaps, loops"
  echo "to the row before. Optimised from the run's own drifting poses on one thread; the error is that of the positions against"
  echo "the truth in the frame of the first pose. Made by \`scripts/scaling.sh\`."
  echo
  echo "![time and memory over size](images/scaling.png)"
  echo
  echo "| keyframes | edges | loops | processor time [s] | peak memory [MiB] | error before [m] | after [m] |"
  echo "|---|---|---|---|---|---|---|"
  awk '{ printf "| %d | %d | %d | %.2f | %.0f | %.2f | %.3f |\n", $1, $2, $3, $4, $5, $6, $7 }' "${work}/graphs.txt"
  echo
  echo "One keyframe's update of window and graph (\`BM_KeyframeOfALongRun\`, medians of a thousand early and a thousand"
  echo "late ones, taken by turns):"
  echo
  awk -F, '
    /^name,/ { for (i = 1; i <= NF; ++i) { gsub(/"/, "", $i); column[$i] = i } }
    /KeyframeOfALongRun/ {
      printf "from keyframe 100 on %.3f ms, up to keyframe 50,000 %.3f ms, ratio %.2f\n",
             $column["early_ms"], $column["late_ms"], $column["ratio"]
    }' "${work}/keyframes.csv"
} > "${work}/scaling.md"
mv "${work}/scaling.md" "${root}/docs/scaling.md"
