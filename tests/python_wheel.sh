#!/bin/sh
# Builds the Python wheel in a clean environment for each named interpreter (default: python3.9 and python3.11). Installs
# it into another environment, and runs the tests, the scripts and mypy there.
#
#   sh tests/python_wheel.sh [PYTHON...]
# The system must have the library's own packages (cmake/packages.sh); pip installs the rest. Status 4: the interpreter
# is missing.
set -eu
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- python3.9 python3.11
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
ran=0
for python in "$@"; do
  if ! "$python" -m venv "$folder/$ran-build" >"$folder/log" 2>&1; then
    echo "== $python: skipped, there is no such interpreter with venv"
    continue
  fi
  echo "== $("$python" --version): wheel"
  "$folder/$ran-build/bin/pip" -q --disable-pip-version-check wheel --no-deps -w "$folder/$ran-wheels" ./plugins/python
  ls -l "$folder/$ran-wheels"
  "$python" -m venv "$folder/$ran"
  "$folder/$ran/bin/pip" -q --disable-pip-version-check install "$folder/$ran-wheels"/enamel-*.whl mypy
  echo "== $("$python" --version): tests, scripts, types"
  (
    unset PYTHONPATH ENAMEL_TOOL
    cp -r plugins/python/scripts tests/python/module.py "$folder/$ran-wheels"
    cd "$folder/$ran-wheels" # outside of the source tree
    for numpy in "numpy<2" "numpy>=2"; do # both must give the same arrays
      "$folder/$ran/bin/pip" -q --disable-pip-version-check install "$numpy"
      "$folder/$ran/bin/python" -c 'import numpy; print("NumPy", numpy.__version__)'
      "$folder/$ran/bin/python" module.py
    done
    for script in scripts/*.py; do "$folder/$ran/bin/python" "$script"; done
    "$folder/$ran/bin/mypy" --strict --ignore-missing-imports scripts/*.py
  )
  ran=$((ran + 1))
done
[ "$ran" -gt 0 ] || { echo "skipped: none of these interpreters is here: $*"; exit 4; }
echo "== the wheel passes on $ran interpreters"
