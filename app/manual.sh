#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
# manual.sh PROGRAM DIR: manual pages of evermap and of its verbs, of what --help says.
set -euo pipefail
program=$1 folder=$2
rm -rf "$folder"
mkdir -p "$folder"
version=$("$program" --version)
page() { # NAME COMMAND...
  local name=$1
  shift
  local summary
  summary=$("$@" --help | head -n 1)
  help2man --no-info --section 1 --version-string "$version" --name "${summary,}" "$*" | gzip -9n >"$folder/$name.1.gz"
}
page evermap "$program"
for verb in $("$program" --help | sed -n '/^Subcommands:/,$s/^  \([a-z]*\) .*/\1/p'); do
  page "evermap-$verb" "$program" "$verb"
done
