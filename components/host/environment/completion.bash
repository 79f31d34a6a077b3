# SPDX-License-Identifier: Apache-2.0
# Completion of `pipescout` in bash: the program itself knows what can stand where, and has the commands of other
# packages say it of themselves. Sourced by the environment hook of the workspace, and by bash-completion from
# share/bash-completion/completions/.

_pipescout_complete() {
  local program=${COMP_WORDS[0]} words=() word behind i IFS=$'\n'
  # bash takes --option=value, NAME:=VALUE and pkg::Class apart.
  for ((i = 1; i <= COMP_CWORD; ++i)); do
    word=${COMP_WORDS[i]}
    if ((i > 1)) && [[ $word == [=:]* || ${COMP_WORDS[i - 1]} == *[=:] ]] && [[ ${COMP_LINE} == *"${words[-1]}$word"* ]]; then
      words[-1]+=$word
    else
      words+=("$word")
    fi
  done
  # It puts the answer in the place of what stands behind the last of these signs.
  word=${words[-1]}
  behind=${word%"${word##*[=:]}"}
  COMPREPLY=()
  for word in $("$program" __complete -- "${words[@]}" 2>/dev/null); do
    if [[ $word == @* ]]; then
      for word in $("$program" __names "${word#@}" 2>/dev/null); do
        [[ $word != "${words[-1]}"* ]] || COMPREPLY+=("${word#"$behind"}")
      done
    else
      COMPREPLY+=("${word#"$behind"}")
    fi
  done
}

complete -o default -F _pipescout_complete pipescout
