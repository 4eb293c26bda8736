#!/usr/bin/env bash
# Builds the documentation as pages for a browser, by Sphinx (docs/) and Doxygen (public headers); any warning of either is an
# error.   scripts/build_docs.sh [FOLDER]     default: build/docs; begin with FOLDER/html/index.html
# What it needs: scripts/install_dependencies.sh --docs
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(mkdir -p "${1:-build/docs}" && cd "${1:-build/docs}" && pwd)
version=$(sed -n 's/^project(trunnion VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
TRUNNION_VERSION=$version /usr/bin/python3 -m sphinx -q -W --keep-going -b html -d "$out/doctrees" docs "$out/html"
sed -e "s|@VERSION@|$version|; s|@OUTPUT@|$out/html|; s|@SOURCE@|$PWD|g" docs/Doxyfile.in >"$out/Doxyfile"
doxygen "$out/Doxyfile"
echo "$out/html/index.html"
