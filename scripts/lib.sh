# shellcheck shell=bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What the scripts share. Source it after `set -euo pipefail`.

acus_root=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P)

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

install_packages() { "$acus_root/scripts/install-packages" || fail "packages are missing, see above"; }

# Configures and builds one preset of CMakePresets.json.
build_preset() {
  local preset=$1
  say "building preset $preset in build/$preset"
  (cd "$acus_root" && cmake --preset "$preset") || fail "configuring preset $preset, see above"
  (cd "$acus_root" && cmake --build --preset "$preset" --parallel "$(nproc)") ||
    fail "building preset $preset, see above"
}
