#!/usr/bin/env bash
# Installs the packages of scripts/packages.txt that are missing. Needs no network and no rights when none is.
set -euo pipefail

script_dir="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
readonly script_dir
readonly list="${script_dir}/packages.txt"

if ! command -v dpkg-query > /dev/null || ! command -v apt-get > /dev/null; then
  echo "install_packages.sh: this system has no apt; install what corresponds to the packages in ${list} by hand" >&2
  exit 1
fi

missing=()
while read -r package; do
  status="$(dpkg-query --show --showformat='${db:Status-Status}' "${package}" 2> /dev/null || true)"
  if [[ "${status}" != "installed" ]]; then
    missing+=("${package}")
  fi
done < <(sed -e 's/#.*//' -e 's/[[:space:]]//g' -e '/^$/d' "${list}")

if [[ ${#missing[@]} -eq 0 ]]; then
  echo "All packages are installed."
  exit 0
fi
echo "Installing: ${missing[*]}"

as_root=()
if [[ "$(id -u)" -ne 0 ]]; then
  if ! command -v sudo > /dev/null; then
    echo "install_packages.sh: installing needs root and there is no sudo; as root, run: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

install() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${missing[@]}"
}
# A fresh machine has no package lists, an old one has stale ones.
if ! { "${as_root[@]}" apt-get update && install; }; then
  echo "install_packages.sh: apt-get failed (its messages are above); check the network and the package sources, then" \
    "run: apt-get install ${missing[*]}" >&2
  exit 1
fi
