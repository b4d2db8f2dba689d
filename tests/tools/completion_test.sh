#!/usr/bin/env bash
# Completion knows every program, and finds its options and built-in names. Usage: completion_test.sh <bin folder>
set -euo pipefail
PATH=$1:$PATH
source "$(dirname "$0")/../../tools/completion.bash"

expect() {  # expect <program> <word begun> <a completion>
  COMPREPLY=()
  _vantage "$1" "$2"
  printf '%s\n' "${COMPREPLY[@]}" | grep -qxF -- "$3" || { echo "$1 $2: no $3 in: ${COMPREPLY[*]}" >&2; exit 1; }
}
expect vantage-run --lo --lockstep
expect vantage-run puma3 puma3-bad-view
expect vantage-map fig fig3
expect vantage-measure ur ur5
COMPREPLY=()
_vantage vantage-run --no-such-option
[ ${#COMPREPLY[@]} -eq 0 ] || { echo "completes an option that is not there: ${COMPREPLY[*]}" >&2; exit 1; }
for program in "$1"/vantage-*; do
  complete -p "$(basename "$program")" >/dev/null || { echo "${program##*/} has no completion" >&2; exit 1; }
done
echo ok
