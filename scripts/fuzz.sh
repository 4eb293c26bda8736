#!/usr/bin/env bash
# Feeds a reader with mutated input: scripts/fuzz.sh READER SECONDS [libFuzzer option…]
# READER: apt, rs274, sinumerik, heidenhain, fanuc, machine_file, linuxcnc_machine, setup_file, controller_file, surface_file, setpoints. What it learns stays in build/fuzz/corpus/READER, so that
# a second run goes on. A find stops it and is kept in build/fuzz/finds/READER; exit status 0 where there is none.
set -euo pipefail
cd "$(dirname "$0")/.."
reader=${1:?reader} seconds=${2:?seconds}
shift 2
scripts/install_dependencies.sh --developer
scripts/build.sh fuzz "fuzz_$reader"

corpus=build/fuzz/corpus/$reader seeds=build/fuzz/seeds/$reader finds=build/fuzz/finds/$reader
mkdir -p "$corpus" "$finds"
rm -rf "$seeds"
mkdir -p "$seeds"
seed() {  # every small file of a folder whose name fits, by link
  local folder=$1
  shift
  [ -d "$folder" ] || return 0
  find "$folder" -type f -size -40k \( -name "$1" "${@:2}" \) | while read -r file; do
    ln -sf "$PWD/$file" "$seeds/$(tr '/' '_' <<<"$file")"
  done
}
shared=$(sed -n 's/^TRUNNION_SHARED_DIR:PATH=//p' build/fuzz/CMakeCache.txt)
shared=$(realpath --relative-to=. "$shared")
longest=4096
case $reader in
  apt) for folder in tests/reject "$shared/data/cases" "$shared/data/nc/apt"; do
         seed "$folder" '*.cls' -o -name '*.apt' -o -name '*.ncl' -o -name '*.aptsource'; done ;;
  rs274) for folder in tests/reject examples "$shared/data/cases" "$shared/data/nc/linuxcnc"; do seed "$folder" '*.ngc'; done ;;
  sinumerik) for folder in tests/reject examples "$shared/data/nc/siemens"; do seed "$folder" '*.mpf' -o -name '*.spf' -o -name '*.nc'; done ;;
  heidenhain) seed tests/reject '*.h'; longest=2048 ;;
  fanuc) for folder in tests/reject "$shared/data/nc/fanuc"; do seed "$folder" '*.nc'; done ;;
  machine_file) seed tests/reject '*.toml'; seed data/machines '*.toml' ;;
  linuxcnc_machine) seed tests/reject '*.ini'; longest=8192 ;;
  setup_file) seed tests/reject '*setup*.toml'; seed examples '*.toml' ;;
  controller_file) seed tests/reject 'controller_*.toml'; seed data/controllers '*.toml'; seed examples '*control*.toml' ;;
  surface_file) seed tests/reject 'surface_*.toml'; seed examples '*.toml'; seed tests/docs '*.toml' ;;
  setpoints) seed "$shared/data/cases" '*.csv'; longest=2048 ;;
esac
for kept in "tests/fuzz/seeds/$reader" "tests/fuzz/finds/$reader"; do seed "$kept" '*'; done

status=0
# A small quarantine: else freed memory is counted as if it were in use.
ASAN_OPTIONS=allocator_may_return_null=1:quarantine_size_mb=16 build/fuzz/tests/fuzz/fuzz_"$reader" "$corpus" "$seeds" \
  -dict="tests/fuzz/dictionaries/$reader.dict" -artifact_prefix="$finds/" -max_total_time="$seconds" -timeout=10 \
  -rss_limit_mb=2048 -max_len="$longest" -print_final_stats=1 "$@" || status=$?
if [ "$status" -ne 0 ]; then
  echo "a find: $(find "$finds" -type f -printf '%T@ %p\n' | sort -n | tail -1 | cut -d' ' -f2)" >&2
  echo "keep it as tests/fuzz/finds/$reader/<what it shows>; fuzz:replay then guards it in every build" >&2
fi
exit "$status"
