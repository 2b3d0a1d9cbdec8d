#!/bin/sh
# Installs what is missing, builds, and shows the speed of the device model beside its error.
set -eu
cd "$(dirname "$0")/.."
. cmake/packages.sh
install_packages

echo "== release: configure and build"
cmake --preset release -DENAMEL_BUILD_TESTS=OFF >/dev/null
cmake --build --preset release

echo "== enamel bench: speed against error"
build/release/apps/enamel/enamel bench --scale 0.5
