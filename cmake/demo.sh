#!/bin/sh
# Installs what is missing, builds, and pushes a tool against a stiff wall with both renderers.
set -eu
cd "$(dirname "$0")/.."
. cmake/packages.sh
install_packages

echo "== release: configure and build"
cmake --preset release -DENAMEL_BUILD_TESTS=OFF >/dev/null
cmake --build --preset release

echo "== a push of 12 N against the wall: the position servo beside the spring"
mkdir -p out
build/release/apps/enamel/enamel push --device data/devices/tau-nominal.toml \
  --renderer position-control,impedance --noise 0 --output out/push.csv

echo "== speed against error"
build/release/apps/enamel/enamel bench --scale 0.2
