#!/usr/bin/env bash
# Makes docs/results.md: builds the programs, simulates the scenarios, maps every run, leaves out one step after the
# other on the first seed, and compares with the exact truth.
#
# usage: scripts/reproduce_tables.sh [--seeds "1 2 3"] [--scenarios "cones citrus"] [--scans N] [--keep] [OUTDIR]
#   --seeds      of the simulated runs (default "1 2 3")
#   --scenarios  some only (default all)
#   --scans      the first N sweeps of each run only, for a trial
#   --keep       keep the recordings (many GB) and take those that are kept already
#   OUTDIR       for everything in between (default tables_output)
# Tables and plots go to OUTDIR and, if nothing was left out, to docs/.
set -euo pipefail

# What is switched off, one step a line: its name|the flags of arborslam_offline.
readonly ablations=(
  "no deskew|--set reduction.deskew=false"
  "no levelling|--set reduction.level=false"
  "moving things kept|--set dynamic.enabled=false"
  "no loops|--odometry_only"
)
readonly all_scenarios=(cones citrus vineyard orchard forest)
# Map cells agree within this [m]; maps are compared where the truth is a map of 0.01 m cells.
readonly map_tolerance=0.03
readonly map_scenarios=" cones "

declare -rA titles=(
  [cones]="on a lawn, legged robot, VLP-16"
  [citrus]="a grove, wheeled robot, VLP-16"
  [vineyard]="rows of vines, wheeled robot, OS1-16"
  [orchard]="mixed trees and followers, legged robot, VLP-16"
  [forest]="natural, handheld, VLP-16"
)
# The best figures of Nazate-Burgos et al. 2026 on the real counterpart, whichever method has them: position RMS, end
# error, anything else.
declare -rA paper_best=(
  [cones]="cones (7 runs) | 0.092 ± 0.011 (theirs) | 0.118 (LeGO-LOAM) | heading RMS 0.091 rad, map 0.923 / 0.805 (theirs)"
  [citrus]="CitrusFarm seq 05 | 0.160 (LeGO-LOAM) | 0.065 (A-LOAM) | "
  [vineyard]="Bacchus 2022-06-08 | 1.126 (theirs) | 0.564 (theirs) | "
  [orchard]="Pullally (3 runs) | 0.470 ± 0.064 (theirs) | 0.276 (theirs) | e_p% 0.268 (theirs)"
  [forest]="- | - | - | "
)

usage() {
  sed -n 's/^# \{0,1\}//; 2,/^set/{/^set/!p}' "${BASH_SOURCE[0]}"
}

fail() {
  echo "reproduce_tables.sh: $1" >&2
  exit "${2:-1}"
}

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
readonly root
readonly bin="${root}/build/release/bin"

seeds=(1 2 3)
scenarios=("${all_scenarios[@]}")
scans=""
keep=false
out=""
is_whole=true
while [[ $# -gt 0 ]]; do
  case "$1" in
    --help | -h)
      usage
      exit 0
      ;;
    --keep)
      keep=true
      shift
      ;;
    --seeds | --scenarios | --scans)
      [[ $# -ge 2 ]] || fail "$1 needs a value" 2
      case "$1" in
        --seeds) read -ra seeds <<< "$2" ;;
        --scenarios) read -ra scenarios <<< "$2" && is_whole=false ;;
        --scans) scans="$2" && is_whole=false ;;
      esac
      shift 2
      ;;
    -*) fail "there is no flag $1; see --help" 2 ;;
    *)
      [[ -z "${out}" ]] || fail "only one OUTDIR can be given" 2
      out="$1"
      shift
      ;;
  esac
done
[[ ${#seeds[@]} -gt 0 && ${#scenarios[@]} -gt 0 ]] || fail "there is nothing to do" 2
for number in "${seeds[@]}" ${scans:+"${scans}"}; do
  [[ "${number}" =~ ^[0-9]+$ ]] || fail "'${number}' is not a whole number" 2
done
for scenario in "${scenarios[@]}"; do
  [[ -v "titles[${scenario}]" ]] || fail "there is no scenario '${scenario}'; there are: ${all_scenarios[*]}" 2
done
out="${out:-${root}/tables_output}"
mkdir -p "${out}/images" "${out}/parts"
out="$(cd "${out}" && pwd)"
readonly seeds scenarios scans keep out is_whole

cd "${root}"
scripts/install_packages.sh
cmake --preset release > /dev/null
cmake --build --preset release --parallel "$(nproc)" --target arborslam_simulate arborslam_offline arborslam_evaluate

recording() { echo "${out}/recordings/$1_$2${scans:+_first_${scans}}"; }
result() { echo "${out}/runs/$1_$2_${3// /_}"; }  # Scenario, seed, variant.

# simulate SCENARIO SEED
simulate() {
  local folder
  folder="$(recording "$1" "$2")"
  if [[ "${keep}" == true && -d "${folder}/clouds" ]]; then
    echo "== $1, seed $2: the recording is there"
    return
  fi
  echo "== $1, seed $2: simulating"
  rm -rf "${folder}" "${folder}.part"
  "${bin}/arborslam_simulate" --scenario "$1" --seed "$2" --output "${folder}.part" --quiet ${scans:+--scans "${scans}"}
  mv "${folder}.part" "${folder}"
}

# map_run SCENARIO SEED VARIANT [FLAG ...]
map_run() {
  local scenario="$1" seed="$2" variant="$3" folder
  shift 3
  folder="$(recording "${scenario}" "${seed}")"
  local config=()
  if [[ -f "config/${scenario}.yaml" ]]; then
    config=(--config "config/${scenario}.yaml")
  fi
  echo "== ${scenario}, seed ${seed}: ${variant}"
  rm -rf "$(result "${scenario}" "${seed}" "${variant}")"
  "${bin}/arborslam_offline" --input "${folder}" --output "$(result "${scenario}" "${seed}" "${variant}")" \
    --ground_truth "${folder}/ground_truth.tum" --threads 1 --quiet "${config[@]}" "$@"
}

# evaluate SCENARIO VARIANT SEEDS TABLE [FLAG ...]: writes the Markdown file TABLE.
evaluate() {
  local scenario="$1" variant="$2" which="$3" table="$4" seed folder run
  shift 4
  local estimates=() references=() summaries=() maps=() map_references=() labels=()
  for seed in ${which}; do
    folder="$(recording "${scenario}" "${seed}")"
    run="$(result "${scenario}" "${seed}" "${variant}")"
    estimates+=("${run}/trajectory.tum")
    references+=("${folder}/ground_truth.tum")
    summaries+=("${run}/summary.json")
    labels+=("seed ${seed}")
    if [[ "${map_scenarios}" == *" ${scenario} "* ]]; then
      maps+=("${run}/map.yaml")
      map_references+=("${folder}/gt_map.yaml")
    fi
  done
  local map_flags=()
  if [[ ${#maps[@]} -gt 0 ]]; then
    map_flags=(--map "${maps[@]}" --map_reference "${map_references[@]}" --map_tolerance "${map_tolerance}"
      --map_beyond_is_unknown)
  fi
  "${bin}/arborslam_evaluate" --estimate "${estimates[@]}" --reference "${references[@]}" --summary "${summaries[@]}" \
    --labels "${labels[@]}" "${map_flags[@]}" --markdown "${table}" "$@" > "${table%.md}.txt"
}

# last_row TABLE LABEL: the table's last row, the mean if there are several, called LABEL.
last_row() {
  local row
  row="$(tail -n 1 "$1")"
  echo "| $2 |${row#|*|}"
}

columns_of() { # What the main table of a scenario shows.
  local columns=(path_length_m ate_se2_rmse_m end_error_m heading_rms_rad roll_rms_rad pitch_rms_rad z_rms_m)
  if [[ "${map_scenarios}" == *" $1 "* ]]; then
    columns+=(map_precision map_sensitivity)
  fi
  columns+=(odometry_ate_se2_rmse_m scan_time_median_ms scan_time_p95_ms peak_memory_mib rejected_percent
    degenerate_percent loops_accepted)
  echo "${columns[@]}"
}
readonly origin_columns=(position_rms_m heading_rms_rad end_error_m position_percent)
readonly ablation_columns=(ate_se2_rmse_m end_error_m heading_rms_rad roll_rms_rad pitch_rms_rad z_rms_m
  rejected_percent scan_time_median_ms)

for scenario in "${scenarios[@]}"; do
  for seed in "${seeds[@]}"; do
    simulate "${scenario}" "${seed}"
    map_run "${scenario}" "${seed}" "all steps"
    if [[ "${seed}" == "${seeds[0]}" ]]; then
      for ablation in "${ablations[@]}"; do
        read -ra flags <<< "${ablation#*|}"
        map_run "${scenario}" "${seed}" "${ablation%%|*}" "${flags[@]}" ||
          echo "reproduce_tables.sh: ${scenario}, seed ${seed}, ${ablation%%|*}: not mapped" >&2
      done
    fi
    # What was needed to compare stays.
    if [[ "${keep}" == false ]]; then
      rm -rf "$(recording "${scenario}" "${seed}")/clouds"
    fi
  done

  parts="${out}/parts/${scenario}"
  read -ra columns <<< "$(columns_of "${scenario}")"
  evaluate "${scenario}" "all steps" "${seeds[*]}" "${parts}_se2.md" --align se2 --columns "${columns[@]}"
  evaluate "${scenario}" "all steps" "${seeds[*]}" "${parts}_origin.md" --align origin --columns "${origin_columns[@]}"
  evaluate "${scenario}" "all steps" "${seeds[*]}" "${parts}_paper.md" --align origin --columns position_rms_m end_error_m
  first="${seeds[0]}"
  "${bin}/arborslam_evaluate" --estimate "$(result "${scenario}" "${first}" "all steps")/trajectory.tum" \
    --reference "$(recording "${scenario}" "${first}")/ground_truth.tum" --labels "${scenario}, seed ${first}" \
    --plot "${out}/images/${scenario}.png" > /dev/null
  evaluate "${scenario}" "all steps" "${first}" "${parts}_ablation.md" --columns "${ablation_columns[@]}"
  {
    sed -n '1s/^| run/| /p; 2p' "${parts}_ablation.md"
    last_row "${parts}_ablation.md" "all steps"
    for ablation in "${ablations[@]}"; do
      name="${ablation%%|*}"
      if [[ -f "$(result "${scenario}" "${first}" "${name}")/summary.json" ]]; then
        evaluate "${scenario}" "${name}" "${first}" "${parts}_ablation.md" --columns "${ablation_columns[@]}"
        last_row "${parts}_ablation.md" "${name}"
      else
        echo "| ${name} | not mapped |"
      fi
    done
  } > "${parts}_ablations.md"
done

{
  cat << 'EOT'
# Results

Made by `scripts/reproduce_tables.sh`: simulated runs with exact ground truth, release build, one thread.

EOT
  echo "Seeds ${seeds[*]}${scans:+, the first ${scans} sweeps of each run}. CPU:" \
    "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1). For each SCENARIO and SEED:"
  cat << 'EOT'

```sh
arborslam_simulate --scenario SCENARIO --seed SEED --output RECORDING
arborslam_offline --input RECORDING --output RUN --ground_truth RECORDING/ground_truth.tum --threads 1 \
  --config config/SCENARIO.yaml   # where there is one
arborslam_evaluate --estimate RUN/trajectory.tum --reference RECORDING/ground_truth.tum --summary RUN/summary.json
```

All errors are planar but for roll, pitch and height. ATE: RMSE of the position after SE(2) alignment without scale.
e_end: position error of the last pose. RMS_p, RMS_th, RMS_rol, RMS_pit, RMS_z: RMS of position, heading, roll, pitch and
height error. e_p%: mean position error over path length. odo_ATE: ATE of `odometry.tum`, the causal trajectory without
loops. t_med, t_p95: time a sweep with projection, median and 95th percentile. reject, degen: sweeps that could not be
matched, and that were matched with a direction that nothing held. The last row is the mean ± 1.96 sd / sqrt(N) over the
seeds.
EOT
  echo "m_prec, m_sens: precision and sensitivity of the map, aligned as the trajectory is, on the truth's 0.01 m grid with a"
  echo "tolerance of ${map_tolerance} m; what lies beyond its edges is not judged."
  cat << 'EOT'

## Beside the paper

Position RMS and end error in the frame of the first pose, as the paper has them (Nazate-Burgos et al. 2026; its best
figure of each column, of whatever method). Ours are of simulated counterparts of its settings, not of its recordings.

| scenario | RMS_p [m] | e_end [m] | real counterpart | paper's best RMS [m] | paper's best end error [m] | other |
|---|---:|---:|---|---:|---:|---|
EOT
  for scenario in "${scenarios[@]}"; do
    echo "$(last_row "${out}/parts/${scenario}_paper.md" "${scenario}") ${paper_best[${scenario}]} |"
  done
  for scenario in "${scenarios[@]}"; do
    echo
    echo "## ${scenario}: ${titles[${scenario}]}"
    echo
    echo "SE(2)-aligned:"
    echo
    cat "${out}/parts/${scenario}_se2.md"
    echo
    echo "In the frame of the first pose:"
    echo
    cat "${out}/parts/${scenario}_origin.md"
    echo
    echo "![${scenario}, seed ${seeds[0]}](images/${scenario}.png)"
  done
  cat << 'EOT'

## What each step contributes

SE(2)-aligned, with one step switched off at a time, on the first seed:

EOT
  for ablation in "${ablations[@]}"; do
    echo "- ${ablation%%|*}: \`${ablation#*|}\`"
  done
  for scenario in "${scenarios[@]}"; do
    echo
    echo "### ${scenario}"
    echo
    cat "${out}/parts/${scenario}_ablations.md"
  done
} > "${out}/results.md.part"
mv "${out}/results.md.part" "${out}/results.md"
echo "wrote ${out}/results.md"
if [[ "${is_whole}" == true ]]; then
  mkdir -p docs/images
  cp "${out}"/images/*.png docs/images/
  cp "${out}/results.md" docs/results.md
  echo "wrote ${root}/docs/results.md"
fi
