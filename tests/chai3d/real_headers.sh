#!/bin/sh
# Compiles the adapter, its example and the declarations of the substitute with CHAI3D's own headers.
#
#   ENAMEL_CHAI3D=DIR sh tests/chai3d/real_headers.sh [CXX [flags]]     # DIR: CHAI3D's sources, 3.2 or 3.3
# Status 4: ENAMEL_CHAI3D is not set.
set -eu
source=$(cd "$(dirname "$0")/../.." && pwd)
# signatures.cpp must check everything in the substitute.
for name in $(grep -v '^ *//' "$source/tests/chai3d/chai3d.h" |
    grep -oE '\b(m_[A-Za-z0-9]+|C_[A-Z]+|c[A-Z][A-Za-z0-9]+|[a-z]+[A-Z][A-Za-z]*|zero|length|identity|open|close|calibrate|signal|initialize|start|stop)\b' |
    sort -u); do
  grep -qw "$name" "$source/tests/chai3d/signatures.cpp" || { echo "signatures.cpp lacks $name of the stand-in"; exit 1; }
done
if [ -z "${ENAMEL_CHAI3D:-}" ]; then
  echo "skipped: needs CHAI3D's sources (ENAMEL_CHAI3D=DIR)"
  exit 4
fi
[ -f "$ENAMEL_CHAI3D/src/chai3d.h" ] || { echo "$ENAMEL_CHAI3D: has no src/chai3d.h"; exit 1; }
compiler=${1:-c++}
[ $# -eq 0 ] || shift
for file in tests/chai3d/signatures.cpp plugins/chai3d/example.cpp; do
  "$compiler" -std=c++17 -fsyntax-only -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Werror \
    -DLINUX -DGLEW_NO_GLU -I "$source/plugins/chai3d" -I "$source/lib/include" "$@" -isystem "$ENAMEL_CHAI3D/src" \
    $(for folder in "$ENAMEL_CHAI3D"/external*/Eigen "$ENAMEL_CHAI3D"/external*/glew/include; do
        echo "-isystem $folder"; done) "$source/$file"
done
grep -m 1 'CHAI3D_VERSION  *"' "$ENAMEL_CHAI3D/src/version.h" || true
