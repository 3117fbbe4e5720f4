#!/usr/bin/env bash
# Installs what the tests need where it is missing, runs every test, and ends with one line of sums.
# Arguments go to `cargo test --release --all-features`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

has_vulkan() {
    [[ -n "${VK_DRIVER_FILES:-}${VK_ICD_FILENAMES:-}" ]] || compgen -G "/usr/share/vulkan/icd.d/*.json" >/dev/null ||
        compgen -G "/etc/vulkan/icd.d/*.json" >/dev/null
}

has_loader() {
    # Not by a pipe into grep -q, which ends ldconfig half way: a failure under pipefail.
    [[ "$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p)" == *libvulkan.so.1* ]]
}

missing=()
has_vulkan || missing+=(mesa-vulkan-drivers)
has_loader || missing+=(libvulkan1)
command -v python3 >/dev/null || missing+=(python3)
python3 -c 'import ensurepip' 2>/dev/null || missing+=(python3-venv)
command -v "${STIFFMAP_CHROMIUM:-chromium}" >/dev/null || missing+=(chromium)

command -v ccx >/dev/null || missing+=(calculix-ccx)
[[ -d /usr/share/doc/calculix-ccx-test/examples/test ]] || missing+=(calculix-ccx-test)

if ((${#missing[@]})); then
    as_root=()
    if ! command -v apt-get >/dev/null; then
        echo "tests/run.sh: the tests need ${missing[*]} (names of Debian's packages), and there is no apt-get to install them with; install them and run this again" >&2
        exit 1
    elif ((EUID != 0)); then
        if ! command -v sudo >/dev/null; then
            echo "tests/run.sh: the tests need ${missing[*]}; run \`apt-get install ${missing[*]}\` as root, then this again" >&2
            exit 1
        fi
        as_root=(sudo)
    fi
    echo "tests/run.sh: installing ${missing[*]}"
    "${as_root[@]}" apt-get update -qq
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}"
fi

# Python with the formats' own readers; it holds a copy of the list that it was made from.
environment=target/test-venv
make_environment() {
    rm -rf "$environment"
    mkdir -p target
    python3 -m venv "$environment"
    "$environment/bin/python" -m pip install --quiet --disable-pip-version-check -r tests/requirements.txt
    cp tests/requirements.txt "$environment/requirements.txt"
}
making=
if ! cmp -s tests/requirements.txt "$environment/requirements.txt"; then
    make_environment &
    making=$!
fi

# What is built and run: everything, with the features that are off by default.
tests=(cargo test --release --all-features)
"${tests[@]}" --no-run "$@"
[[ -z "$making" ]] || wait "$making"

# A cache of its own, empty at the start: tests neither read nor write the user's.
rm -rf target/test-cache
export STIFFMAP_PYTHON="$PWD/$environment/bin/python"
export STIFFMAP_GPU=require
export STIFFMAP_CCX=require
export STIFFMAP_CACHE="$PWD/target/test-cache"

log=target/test-output.txt
status=0
"${tests[@]}" --no-fail-fast "$@" 2>&1 | tee "$log" || status=$?
awk '/^test result:/ {
    for (i = 2; i <= NF; i++) {
        if ($i == "passed;") passed += $(i - 1)
        if ($i == "failed;") failed += $(i - 1)
        if ($i == "ignored;") skipped += $(i - 1)
    }
}
END { printf "%d passed, %d failed, %d skipped\n", passed, failed, skipped }' "$log"
exit "$status"
