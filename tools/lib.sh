# shellcheck shell=bash
# What the scripts `demo` and `test` share: sourced, never run.

# Prints a line that stands out, and nothing to stdout, which belongs to the programs.
say() { printf '%s\n' "==> $*" >&2; }

# Ends the script with one line.
die() {
  printf '%s\n' "error: $*" >&2
  exit 1
}

has() { command -v "$1" >/dev/null 2>&1; }

# Cargo's own folder may not be on the path of a fresh shell.
find_cargo() {
  has cargo || PATH="$PATH:${CARGO_HOME:-${HOME:-}/.cargo}/bin"
  has cargo || die "cargo is missing; install Rust 1.88 or newer with rustup, then run this again"
}

# The shader compiler that the build brings along is C++.
find_compiler() {
  local compiler
  for compiler in "${CXX:-}" c++ g++ clang++; do
    [ -n "$compiler" ] && has "${compiler%% *}" && return
  done
  die "a C++ compiler is missing; install one (Debian and Ubuntu: g++, Fedora: gcc-c++, Arch: gcc), then run this again"
}

# Debian and what derives from it.
has_apt() { has apt-get && [ -e /etc/debian_version ]; }

# install_packages PURPOSE PACKAGE...: through apt-get where there is one, else says what is needed.
install_packages() {
  local purpose=$1 as_root=()
  shift
  has_apt || die "$purpose is missing; install what your system calls $*, then run this again"
  if [ "$(id -u)" -ne 0 ]; then
    has sudo || die "$purpose is missing and needs root to install; run as root: apt-get install $*"
    as_root=(sudo)
  fi
  say "$purpose is missing: installing $* with apt-get"
  # Fresh machines have no package lists yet, others stale ones.
  if [ -z "${lists_updated:-}" ]; then
    "${as_root[@]}" apt-get -q update >&2 || say "the package lists could not be updated; trying with the old ones"
    lists_updated=yes
  fi
  apt_install "$@" || die "apt-get could not install $*; see its message above"
}

# Runs within install_packages, whose as_root it sees.
apt_install() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get -q install -y --no-install-recommends "$@" >&2
}

# Whether ldconfig, which is not on every user's path, knows the Vulkan loader.
has_loader() {
  PATH="$PATH:/usr/sbin:/sbin" ldconfig -p 2>/dev/null | grep -c 'libvulkan\.so\.1 ' >/dev/null
}

# has_manifest KIND NAME: whether the loader finds a manifest of this kind and name (a pattern) in the
# folders it searches.
has_manifest() {
  local base file
  local -a bases
  IFS=: read -r -a bases <<<"${XDG_CONFIG_HOME:-${HOME:-}/.config}:${XDG_CONFIG_DIRS:-/etc/xdg}:/etc:/usr/local/etc:${XDG_DATA_HOME:-${HOME:-}/.local/share}:${XDG_DATA_DIRS:-/usr/local/share:/usr/share}"
  for base in "${bases[@]}"; do
    for file in "$base/vulkan/$1"/$2.json; do
      [ -e "$file" ] && return
    done
  done
  return 1
}

# A driver is there if the loader's own variables name one, or a usual folder holds one.
has_driver() {
  local entry
  local -a named
  IFS=: read -r -a named <<<"${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}"
  for entry in "${named[@]}"; do
    [ -e "$entry" ] && return
  done
  # These variables replace the search, so what they name and what is not there counts as missing.
  [ "${#named[@]}" -eq 0 ] || die "VK_DRIVER_FILES or VK_ICD_FILENAMES names no file that exists; mend or unset it"
  has_manifest icd.d "*"
}

# A Vulkan loader and a driver; installs Mesa's only where there is none, so that no vendor's driver is
# disturbed.
ensure_vulkan() {
  has_loader || install_packages "the Vulkan loader" libvulkan1
  has_driver || install_packages "a Vulkan driver" mesa-vulkan-drivers
}

# ensure_device PROGRAM: a driver whose hardware is not there offers no device; then Mesa's software
# driver helps.
ensure_device() {
  "$1" doctor >/dev/null 2>&1 && return
  [ -z "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ] || {
    "$1" doctor >&2 || die "the drivers that VK_DRIVER_FILES or VK_ICD_FILENAMES names do not do; mend or unset it"
  }
  install_packages "a Vulkan device that works" mesa-vulkan-drivers
  "$1" doctor >&2 || die "there is still no usable Vulkan device; see above what is missing"
}

has_validation() {
  local folder
  local -a folders
  IFS=: read -r -a folders <<<"${VK_LAYER_PATH:-}"
  for folder in "${folders[@]}"; do
    [ -e "$folder/VkLayer_khronos_validation.json" ] && return
  done
  has_manifest explicit_layer.d VkLayer_khronos_validation
}

ensure_validation() {
  has_validation || install_packages "the Vulkan validation layer" vulkan-validationlayers
}
