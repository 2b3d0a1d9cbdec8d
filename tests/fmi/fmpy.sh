#!/bin/sh
# Tests units with an independent master in a virtual environment. FMPy validates them against the standard's schema and
# drives them. Its copy of the official headers is compared with our declarations.
#
#   sh tests/fmi/fmpy.sh ENAMEL [PYTHON]     # the built command-line tool; python3
# ENAMEL_FMPY, if set, is a Python with FMPy; otherwise pip installs it. Status 4: this is not possible.
set -eu
enamel=$1 python=${2:-python3}
source=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
if [ -z "${ENAMEL_FMPY:-}" ]; then
  if [ -z "${ENAMEL_LONG:-}" ]; then
    echo "skipped: needs FMPy (ENAMEL_FMPY=PYTHON, or --long, which installs it with pip)"
    exit 4
  fi
  if ! { "$python" -m venv "$folder/venv" && "$folder/venv/bin/pip" -q --disable-pip-version-check install fmpy; } \
      >"$folder/log" 2>&1; then
    tail -n 3 "$folder/log"
    echo "skipped: FMPy cannot be installed"
    exit 4
  fi
  ENAMEL_FMPY=$folder/venv/bin/python
fi
headers=$("$ENAMEL_FMPY" -c 'import fmpy, os; print(os.path.join(os.path.dirname(fmpy.__file__), "c-code"))')
c++ -std=c++17 -fsyntax-only -isystem "$headers" -I "$source" "$source/tests/fmi/headers.cpp"
for type in $(grep -o 'fmi3[A-Za-z0-9]*TYPE' "$headers/fmi3FunctionTypes.h" | sort -u); do
  grep -q "X(${type%TYPE}," "$source/plugins/fmi/fmi3.hpp" || { echo "fmi3.hpp lacks ${type%TYPE}"; exit 1; }
done
"$ENAMEL_FMPY" "$source/tests/fmi/fmpy_master.py" "$enamel" "$source"
