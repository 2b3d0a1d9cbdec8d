#!/bin/sh
# Installs missing packages, builds, pushes a tool against a stiff wall with every renderer, and repeats that over the
# wall. Then it opens the viewer for the same by hand; without a display, the viewer records the push.
set -eu
cd "$(dirname "$0")/.."
. cmake/packages.sh
install_packages

echo "== release: configure and build"
cmake --preset release -DENAMEL_BUILD_TESTS=OFF >/dev/null
cmake --build --preset release
viewer=build/release/apps/viewer/enamel-viewer

echo "== a push of 12 N against the wall: position control, the paper's servo and the spring"
mkdir -p out
build/release/apps/enamel/enamel push --device data/devices/tau-nominal.toml \
  --renderer position-control,hold,impedance --device-damping 4 --noise 0 --output out/push.csv --overwrite

echo "== a small study with the paper's forces, 8 to 15 N, then those of crown preparations, 0.1 to 4.9 N:"
echo "   9 query points, 3 runs each; the whole one is: enamel study --output out/study"
build/release/apps/enamel/enamel study --grid 3 --runs 3 --output out/small-study --overwrite

echo "== speed against error"
build/release/apps/enamel/enamel bench --scale 0.2

if [ ! -x "$viewer" ]; then
  echo "== no viewer: VTK, GLFW, GLM or Dear ImGui is missing"
elif [ -n "${DISPLAY:-}" ]; then
  echo "== the viewer: drag the tool to move the hand, press at the left, Tab swaps the renderers, F1 lists every key"
  exec "$viewer"
else
  echo "== no display: the push is recorded; the pictures:"
  "$viewer" --headless --script data/scripts/push.txt --record out --overwrite
fi
