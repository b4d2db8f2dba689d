# Completion for bash of Vantage's programs: `source tools/completion.bash`; the Debian package installs it. Options
# and names are asked of the programs themselves, so they cannot drift.

_vantage() {
  local program=$1 current=$2 words
  local help
  help=$("$program" --help 2>/dev/null) || return
  if [[ $current == -* ]]; then
    words=$(grep -oE -- '--[a-z][a-z-]*' <<<"$help" | sort -u)
  elif grep -q -- '--list' <<<"$help"; then
    words=$("$program" --list 2>/dev/null | sed -nE 's/^[* ]*([A-Za-z0-9_-]+).*/\1/p')
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}

complete -o default -F _vantage vantage-{run,servo,sim,camera,measure,map,plan,plan-mpi,bench,report,watch,panda-bridge,config}
