#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 the evermap authors
# SPDX-License-Identifier: BSD-3-Clause
# pulled_cable.sh PROGRAM [SECONDS]: a robot's two computers, each a network of its own with a cable between them, which is pulled
# for so long while clouds go over it. The map's keeper says so, and goes on where the robot is. Exit code 77 where no networks
# can be made.
set -euo pipefail

program=$1
seconds=${2-5}
id=$$
sensor=evermap-sensor-$id
keeper=evermap-keeper-$id
domain=$((1 + id % 100))
folder=$(mktemp -d)
clean() {
  # shellcheck disable=SC2046
  kill $(jobs -p) 2>/dev/null || true
  wait
  ip netns del "$sensor" 2>/dev/null || true
  ip netns del "$keeper" 2>/dev/null || true
  rm -rf "$folder"
}
trap clean EXIT
ip netns add "$keeper" 2>/dev/null || exit 77
ip netns add "$sensor"
ip link add "a$id" netns "$keeper" type veth peer name "b$id" netns "$sensor"
ip -n "$keeper" address add 10.99.7.1/24 dev "a$id"
ip -n "$sensor" address add 10.99.7.2/24 dev "b$id"
for end in "$keeper a$id" "$sensor b$id"; do
  read -r space device <<<"$end"
  ip -n "$space" link set lo up
  ip -n "$space" link set "$device" up
done

"$program" simulate yard -o "$folder/yard" 2>/dev/null >/dev/null
"$program" import "$folder/yard/survey.ply" -r 0.4 -o "$folder/map.evm" >/dev/null
start=$(sed -n '1s/^[^ ]* //p' "$folder/yard/poses.txt")
ip netns exec "$keeper" "$program" serve "$folder/map.evm" --domain "$domain" --port 7447 --initial-pose "$start" >"$folder/serve" 2>&1 &
serve=$!

status() { ip netns exec "$keeper" curl -s --max-time 5 http://localhost:7447/api/status || true; }
value() { sed -n "s/.*\"$1\":\"\([^\"]*\)\".*/\1/p"; }
used() { local count; count=$(status | value 'clouds used'); echo "${count:-0}"; }
until_true() {  # WHAT COMMAND...
  local what=$1 end=$((SECONDS + 60))
  shift
  until "$@"; do
    if [[ $SECONDS -ge $end ]]; then
      echo "$what did not happen; the keeper says: $(status)" >&2
      cat "$folder/serve" >&2
      exit 1
    fi
    sleep 0.2
  done
}
used_more_than() { [[ $(used) -gt $1 ]]; }
says() { [[ $(status) == *"$1"* ]]; }

ip netns exec "$sensor" "$program" play "$folder/yard/scans" --odometry "$folder/yard/poses.txt" --domain "$domain" --speed 0.3 \
  --repeat 50 >/dev/null 2>&1 &
until_true 'a cloud' used_more_than 10
ip -n "$keeper" link set "a$id" down
before=$(used)
until_true 'the warning' says 'no cloud comes on /points'
sleep "$seconds"
ip -n "$keeper" link set "a$id" up
until_true 'a cloud after the cable was back' used_more_than $((before + 20))
until_true 'tracking' says '"state":"tracking"'
kill -TERM "$serve"
code=0
wait "$serve" || code=$?
[[ $code -eq 143 ]] || { echo "the keeper ended with $code" >&2 && cat "$folder/serve" >&2 && exit 1; }
"$program" verify "$folder/map.evm" >/dev/null
echo "used $before clouds before, and went on after $seconds s without a cable"
