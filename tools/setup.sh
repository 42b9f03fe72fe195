#!/bin/sh
# All set-up, from a bare Debian (python3, make, git) to a .venv that runs: virtual environment, locked dependencies,
# a C compiler, OpenGL libraries. Installs Debian packages where it may (as root, or by sudo without a password); elsewhere it names
# the missing package in one line and stops. Safe to run again.
set -eu
cd "$(dirname "$0")/.."
venv=.venv

say() { printf 'setup: %s\n' "$*" >&2; }
fail() { say "$*"; exit 1; }

apt_install() { # apt_install PACKAGE...: false where apt may not be used
    command -v apt-get >/dev/null || return 1
    if [ "$(id -u)" = 0 ]; then as_root=; elif sudo -n true 2>/dev/null; then as_root="sudo -n"; else return 1; fi
    say "installing Debian packages: $*"
    $as_root apt-get update -qq >&2 || say "apt-get update failed; trying with the lists at hand"
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >&2
}

find_python() {
    for python in ${PYTHON:-} python3 python3.14 python3.13 python3.12 python3.11; do
        if "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null; then echo "$python"; return; fi
    done
    fail "needs Python 3.11 or later: on Debian run 'apt-get install python3' (or set PYTHON to one)"
}

make_venv() { # Debian's python3 comes without the module that puts pip into a new environment
    python=$1
    rm -rf "$venv"
    "$python" -m venv "$venv" >/dev/null 2>&1 && return
    rm -rf "$venv"
    "$python" -m virtualenv -q "$venv" 2>/dev/null && return
    rm -rf "$venv"
    apt_install python3-venv && "$python" -m venv "$venv" && return
    rm -rf "$venv"
    fail "$python cannot make virtual environments: on Debian run 'apt-get install python3-venv'"
}

if [ "${1:-}" = --browser ]; then # for the tests of the report alone
    command -v chromium >/dev/null || apt_install chromium || say "no chromium: the report's test in it will be skipped"
    exit 0
fi

if [ "${1:-}" = --viewer ]; then # for the tests that look at recordings in Rerun's viewer, without a screen
    ls /usr/share/vulkan/icd.d/*lvp* >/dev/null 2>&1 || apt_install mesa-vulkan-drivers ||
        say "no mesa-vulkan-drivers: the tests that look at recordings in Rerun's viewer will be skipped"
    exit 0
fi

if [ "${1:-}" = --node ]; then # for the linter and the type checker of the playground's JavaScript
    { command -v node >/dev/null && command -v npm >/dev/null; } || apt_install nodejs npm ||
        say "no node and npm: the playground's JavaScript will not be checked"
    exit 0
fi

if [ "${1:-}" = --firmware ]; then # for the programs of the robot's chip: a cross compiler and an emulator
    if ! command -v arm-none-eabi-gcc >/dev/null || ! command -v qemu-system-arm >/dev/null; then
        apt_install gcc-arm-none-eabi qemu-system-arm ||
            say "no gcc-arm-none-eabi or qemu-system-arm: the tests of the firmware will be skipped"
    fi
    exit 0
fi

if [ "${1:-}" = --docs ]; then # the documentation's own packages
    "$venv/bin/python" -c 'import sphinx, myst_nb, pydata_sphinx_theme, numpydoc, sphinx_design, sphinx_copybutton, ziglang' \
        2>/dev/null && exit 0
    say "installing what the documentation is built with (some 160 MB, most of it a C compiler for the playground)"
    "$venv/bin/python" -m pip install -q --disable-pip-version-check --require-hashes -r docs/requirements.lock
    exit 0
fi

if [ "${1:-}" = --release ]; then # what a release is built and checked with, in an environment of its own
    [ build/release/.ready -nt tools/release.lock ] && exit 0
    say "installing what a release is built and checked with (some 120 MB)"
    "$venv/bin/python" -m venv --clear build/release
    build/release/bin/python -m pip install -q --disable-pip-version-check --require-hashes -r tools/release.lock
    touch build/release/.ready
    exit 0
fi

if [ "${1:-}" = --fit ]; then # the extra [fit], which the lock leaves out: into the .venv that is there
    "$venv/bin/python" -c 'import optuna' 2>/dev/null && exit 0
    say "installing Optuna (some 20 MB)"
    "$venv/bin/python" -m pip install -q --disable-pip-version-check -e '.[fit]' --no-build-isolation
    exit 0
fi

if [ "${1:-}" = --live ]; then # the extra [live], which the lock leaves out: into the .venv that is there
    "$venv/bin/python" -c 'import viser' 2>/dev/null && exit 0
    say "installing viser (some 20 MB)"
    "$venv/bin/python" -m pip install -q --disable-pip-version-check -e '.[live]' --no-build-isolation
    exit 0
fi

if [ "${1:-}" = --swarm ]; then # the extra [swarm], which the lock leaves out: into the .venv that is there
    "$venv/bin/python" -c 'import pettingzoo' 2>/dev/null && exit 0
    say "installing PettingZoo (some 1 MB)"
    "$venv/bin/python" -m pip install -q --disable-pip-version-check -e '.[swarm]' --no-build-isolation
    exit 0
fi

if [ "${1:-}" = --train ]; then # the extra [train], which the lock leaves out: into the .venv that is there
    "$venv/bin/python" -c 'import stable_baselines3, torch' 2>/dev/null && exit 0
    torch=2.13.0
    pip="$venv/bin/python -m pip install -q --disable-pip-version-check"
    say "installing PyTorch and stable-baselines3 (some 300 MB)"
    if ! "$venv/bin/python" -c 'import torch' 2>/dev/null && ! $pip "torch==$torch+cpu" 2>/dev/null; then
        say "no CPU build of PyTorch $torch at hand: on Linux what comes instead may be some GB of CUDA;" \
            "Ctrl-C, install its CPU build into $venv, and run this again to do without"
        $pip "torch==$torch"
    fi
    $pip -e '.[train,onnx]' --no-build-isolation
    $pip "flyvis==1.2.0" "torch==$torch" || say "no flyvis: the test of its example will be skipped"
    say "ready to train"
    exit 0
fi

python=$(find_python)
if ! "$venv/bin/python" -m pip --version >/dev/null 2>&1; then
    say "making $venv with $($python --version)"
    make_venv "$python"
fi

say "installing the locked dependencies (some 300 MB the first time)"
"$venv/bin/python" -m pip install -q --disable-pip-version-check --require-hashes -r requirements.lock
# The network in C needs a compiler and Python's headers; without them its reference runs, in NumPy.
headers() { "$venv/bin/python" -c 'import pathlib, sysconfig; pathlib.Path(sysconfig.get_path("include"), "Python.h").stat()' 2>/dev/null; }
command -v cc >/dev/null || command -v gcc >/dev/null || command -v clang >/dev/null || apt_install gcc libc6-dev || true
headers || apt_install python3-dev || true
"$venv/bin/python" -m pip install -q --disable-pip-version-check --no-deps --no-build-isolation -e .
"$venv/bin/python" -c 'from dsnn import forms; note = forms.note(); print(f"setup: {note}" * bool(note), end="")' >&2

draws() { "$venv/bin/python" -c 'from colias_sim.reference import reference_hash; reference_hash()'; }
if ! draws 2>/dev/null; then
    apt_install libegl1 libgl1 || say "OpenGL cannot draw here"
    draws
fi
touch "$venv/.ready"
say "ready"
