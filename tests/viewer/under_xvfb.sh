#!/bin/sh
# Runs a command under a separate X server, and ends with its status.
#
#   sh tests/viewer/under_xvfb.sh "SERVER OPTIONS" COMMAND...
# The server selects a free display and reports its number when it accepts connections: no fixed waiting time.
set -eu
folder=$(mktemp -d)
server=
trap 'rm -rf "$folder"; [ -z "$server" ] || kill "$server" 2>/dev/null || true' EXIT
trap 'exit 143' INT TERM
mkfifo "$folder/display"
Xvfb -displayfd 3 -nolisten tcp $1 3>"$folder/display" >"$folder/log" 2>&1 &
server=$!
shift
read -r number <"$folder/display" || { cat "$folder/log" >&2; exit 1; }
status=0
DISPLAY=:$number "$@" || status=$?
exit $status
