#!/bin/sh
# Installs what a fresh Debian or Ubuntu lacks to build, run and test hypertexture; does nothing where nothing is missing.
# Where it cannot (another system, no root, no network), it ends with a line that says what is needed.
# `./setup.sh --backports` also takes the faster Mesa of Debian 12's backports, where that suite is configured.
set -eu
cd "$(dirname "$0")"
fail() { echo "setup.sh: $1" >&2; exit 1; }
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }
install() { as_root env DEBIAN_FRONTEND=noninteractive apt-get install -yq --no-install-recommends "$@"; }
missing() { for package in "$@"; do dpkg -s "$package" >/dev/null 2>&1 || printf ' %s' "$package"; done; }

build="g++ libshaderc-dev spirv-tools"
run="libvulkan1 mesa-vulkan-drivers vulkan-validationlayers"
# The window on X11 (Wayland's library comes with Mesa), and a display that nobody sees, for its tests.
window="libx11-6 libx11-xcb1 libxcursor1 libxi6 libxkbcommon-x11-0 xvfb xclip"
# Rust: what Cargo.toml asks for.
needed=$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)
found() { rustc --version 2>/dev/null | sed -n 's/^rustc \([0-9.]*\).*/\1/p'; }
new_enough() {
    command -v cargo >/dev/null && [ "$(printf '%s\n%s\n' "$needed" "$(found)" | sort -V | head -n 1)" = "$needed" ]
}
rust=
new_enough || command -v rustup >/dev/null || rust="Rust $needed or later as https://rustup.rs says"

# shellcheck disable=SC2086 # lists of package names, here and below
packages=$(missing $build $run $window)
command -v apt-get >/dev/null || [ -z "$packages" ] ||
    fail "there is no apt-get here; install what Debian calls$packages${rust:+, and $rust}, and leave this out"
root=
failed=
if [ -n "$packages$rust" ] && as_root true; then
    root=yes
    as_root apt-get update -q -o APT::Update::Error-Mode=any || failed="the lists of packages"
fi
# Without a packaged shaderc, cargo builds it from source: the same result, minutes later.
if [ -n "$packages" ] && apt-cache show g++ >/dev/null 2>&1 && ! apt-cache show libshaderc-dev >/dev/null 2>&1; then
    # shellcheck disable=SC2086
    packages=$(missing g++ cmake ninja-build python3 git $run $window)
fi
if [ -n "$packages" ]; then
    [ -n "$root" ] ||
        fail "only root may install what is missing: apt-get update && apt-get install --no-install-recommends$packages${rust:+; and $rust}; then run this again"
    # shellcheck disable=SC2086
    if ! install $packages; then
        [ -z "$failed" ] || fail "the download of$packages failed, for the reason above; run this again with a network"
        fail "apt-get could not install$packages, for the reason above"
    fi
fi
if ! new_enough; then
    # rustup is packaged from Debian 13 and Ubuntu 24.04 on. An older Rust from packages stays: rustup cannot be beside it.
    if [ -n "$rust" ] && [ -n "$root" ] && apt-cache show rustup >/dev/null 2>&1 && apt-get install -sq --no-remove rustup >/dev/null 2>&1; then
        install rustup ca-certificates gcc libc6-dev || failed=rustup
    fi
    if command -v rustup >/dev/null; then
        rustup update stable || failed="Rust by rustup"
        rustup default >/dev/null 2>&1 || rustup default stable || failed="Rust by rustup"
    fi
    if ! new_enough; then
        found=$(found)
        found="Rust $needed or later is needed and ${found:-none} was found"
        [ -z "$failed" ] || found="Rust $needed or later is needed, and the download of $failed failed, for the reason above"
        fail "$found; install it as https://rustup.rs says, then run this again"
    fi
fi
if [ "${1-}" = --backports ]; then
    # shellcheck source=/dev/null
    install -t "$(. /etc/os-release; echo "$VERSION_CODENAME")-backports" mesa-vulkan-drivers
fi
