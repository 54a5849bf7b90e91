# shellcheck shell=bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What the scripts share. Source it after `set -euo pipefail`.

acus_root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)
acus_bin=$acus_root/build/release/bin

say() { printf '== %s\n' "$*"; }

fail() {
  printf '%s: failed: %s\n' "${0##*/}" "$*" >&2
  exit 1
}

# Prints the comment block at the top of the calling script for -h and --help.
help_if_asked() {
  case "${1:-}" in
    -h | --help)
      sed -n '/^# SPDX/d; /^#!/d; /^#/!q; s/^# \{0,1\}//p' "$0"
      exit 0
      ;;
  esac
}

# install_packages GROUP...: of scripts/packages.txt
install_packages() { "$acus_root/scripts/install-packages" "$@" || fail "packages are missing, see above"; }

# build_preset PRESET [TARGET...]: configures one preset of CMakePresets.json and builds the targets, or all.
build_preset() {
  local preset=$1 targets=()
  (($# == 1)) || targets=(--target "${@:2}")
  say "building preset $preset in build/$preset"
  (cd "$acus_root" && cmake --preset "$preset") || fail "configuring preset $preset, see above"
  (cd "$acus_root" && cmake --build --preset "$preset" --parallel "$(nproc)" "${targets[@]}") ||
    fail "building preset $preset, see above"
}

# Prints a regular expression for the names of all tests in folders of tests/: tests_of_parts PRESET PART...
tests_of_parts() {
  local part
  for part in "${@:2}"; do
    (cd "$acus_root" && ctest --test-dir "build/$1/tests/$part" --show-only) |
      sed -n 's/^ *Test *#[0-9]*: \([^. ]*\).*/\1/p'
  done | sort -u | paste -s -d '|' | sed 's/.*/^(&)([.]|$)/'
}

fail_with_log() {
  local log
  for log in "${@:2}"; do
    printf '%s\n' "-- last lines of $log" >&2
    tail -n 20 "$log" >&2
  done
  fail "$1"
}
