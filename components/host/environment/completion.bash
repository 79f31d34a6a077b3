# SPDX-License-Identifier: Apache-2.0
# Completion of `pipescout` in bash: the program itself knows what can stand where. Sourced by the
# environment hook of the workspace, and by bash-completion from share/bash-completion/completions/.

_pipescout_complete() {
  local word IFS=$'\n'
  COMPREPLY=()
  for word in $("${COMP_WORDS[0]}" __complete -- "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null); do
    COMPREPLY+=("$word")
  done
}

complete -o default -F _pipescout_complete pipescout
