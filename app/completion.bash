# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
# Completes evermap's verbs and their options, as its own help lists them; what is no option is a file.
_evermap() {
  local current=${COMP_WORDS[COMP_CWORD]} words=
  if [[ $COMP_CWORD -eq 1 ]]; then
    words=$(evermap --help 2>/dev/null | sed -n '/^Subcommands:/,$s/^  \([a-z]*\) .*/\1/p')
  elif [[ $current == -* ]]; then
    words=$(evermap "${COMP_WORDS[1]}" --help 2>/dev/null | sed -n 's/^  \(-.,\)\{0,1\}\(--[a-z-]*\).*/\2/p')
  fi
  COMPREPLY=()
  local word
  while read -r word; do [[ -z $word ]] || COMPREPLY+=("$word"); done <<<"$(compgen -W "$words" -- "$current")"
}
complete -o default -F _evermap evermap
