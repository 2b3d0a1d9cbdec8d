#!/bin/sh
# Installs what is missing, builds, and lets you push a tool against a stiff wall: in a window where there is a display,
# else as a recording with both renderers.
set -eu
cd "$(dirname "$0")/.."
. cmake/packages.sh
install_packages

echo "== release: configure and build"
cmake --preset release -DENAMEL_BUILD_TESTS=OFF >/dev/null
cmake --build --preset release
viewer=build/release/apps/viewer/enamel-viewer

echo "== enamel bench: speed against error"
build/release/apps/enamel/enamel bench --scale 0.5

if [ ! -x "$viewer" ]; then
  echo "== no viewer: VTK, GLFW, GLM or Dear ImGui is missing"
elif [ -n "${DISPLAY:-}" ]; then
  echo "== the viewer: drag to move the hand, wheel to press, Tab swaps the renderers, F1 lists every key"
  exec "$viewer"
else
  echo "== no display: a push of 12 N with both renderers, recorded; the pictures:"
  "$viewer" --headless --script data/scripts/push.txt --record out
fi
