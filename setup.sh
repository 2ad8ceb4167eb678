#!/bin/sh
# Installs what a fresh Debian or Ubuntu lacks to build, run and test hypertexture; does nothing where nothing is missing.
# `./setup.sh --backports` also takes the faster Mesa of Debian 12's backports, where that suite is configured.
set -eu
cd "$(dirname "$0")"
sudo=; [ "$(id -u)" = 0 ] || sudo=sudo
install() {
    missing=
    for package in "$@"; do dpkg -s "$package" >/dev/null 2>&1 || missing="$missing $package"; done
    # shellcheck disable=SC2086 # a list of package names
    [ -z "$missing" ] || $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -yq --no-install-recommends $missing
}
present() { for package in "$@"; do dpkg -s "$package" >/dev/null 2>&1 || return 1; done; }

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
if ! new_enough; then
    # rustup is packaged from Debian 13 and Ubuntu 24.04 on. An older Rust from packages stays: rustup cannot be beside it.
    if ! command -v rustup >/dev/null; then
        $sudo apt-get update -q >/dev/null 2>&1 || true
        if apt-cache show rustup >/dev/null 2>&1 && apt-get install -sq --no-remove rustup >/dev/null 2>&1; then
            install rustup ca-certificates gcc libc6-dev
        fi
    fi
    if command -v rustup >/dev/null; then
        rustup update stable || true
        rustup default >/dev/null 2>&1 || rustup default stable || true
    fi
    if ! new_enough; then
        found=$(found)
        echo "setup.sh: Rust $needed or later is needed and ${found:-none} was found; install it as https://rustup.rs says, then run this again" >&2
        exit 1
    fi
fi

# shellcheck disable=SC2086
if ! present $build $run $window; then
    $sudo apt-get update -q
    # Without a packaged shaderc, cargo builds it from source: the same result, minutes later.
    apt-cache show libshaderc-dev >/dev/null 2>&1 || build="g++ cmake ninja-build python3 git"
    install $build $run $window
fi
if [ "${1-}" = --backports ]; then
    # shellcheck source=/dev/null
    $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -yq -t "$(. /etc/os-release; echo "$VERSION_CODENAME")-backports" mesa-vulkan-drivers
fi

# Debian 12's libshaderc.so leaves glslang and SPIRV-Tools symbols undefined, so nothing links against it:
# there, cargo is told to link the static archives instead of running the build script of shaderc-sys.
archives=/usr/lib/$(gcc -dumpmachine)
if [ -e "$archives/libshaderc.so" ] && nm -D --undefined-only "$archives/libshaderc.so" | grep -q 7glslang; then
    mkdir -p .cargo
    {
        echo "[target.$(rustc -vV | sed -n 's/^host: //p').shaderc]"
        echo "rustc-link-search = [\"native=$archives\"]"
        printf 'rustc-link-lib = ['
        for archive in shaderc_combined glslang MachineIndependent GenericCodeGen OSDependent OGLCompiler HLSL SPIRV \
            SPVRemapper SPIRV-Tools-opt SPIRV-Tools; do
            [ ! -e "$archives/lib$archive.a" ] || printf '"static:-bundle=%s", ' "$archive"
        done
        echo ']'
    } > .cargo/config.toml
fi
