# shellcheck shell=bash
# SPDX-License-Identifier: GPL-3.0-or-later
# One server and one replay at a time, which a script starts, watches and ends. Source it after lib.sh.

server=      # pid, empty while none runs
server_log=  # where it writes
replay=      # pid, empty while none runs
beside=      # pid of what else runs beside them, empty while nothing does
endpoints=() # of the server, as options of both programs
sockets=     # folder for its sockets; empty: loopback ports

states_may_be_lost= # empty: no

# Ends what the script started and has not seen ending, whatever ends the script.
clean_up_at_exit() {
  trap clean_up EXIT
  trap 'exit 130' INT
  trap 'exit 143' TERM
}

clean_up() {
  local pid
  for pid in $replay $beside $server; do
    kill "$pid" 2>/dev/null || continue
    wait "$pid" 2>/dev/null || true
  done
  [[ -z $sockets ]] || rm -rf "$sockets"
}

# Waits for the program whose pid the named variable holds and forgets it, so that nothing else is ever killed.
wait_for() {
  local name=$1 pid=${!1} status=0
  wait "$pid" || status=$?
  printf -v "$name" ''
  return "$status"
}

# Prints two loopback ports that nobody uses.
free_ports() {
  /usr/bin/python3 - <<'PYTHON'
import socket
sockets = [socket.socket() for _ in range(2)]
for each in sockets:
    each.bind(("127.0.0.1", 0))
print(*(each.getsockname()[1] for each in sockets))
PYTHON
}

# start_server SCENE LOG [OPTION...]
start_server() {
  local scene=$1 command_port state_port
  server_log=$2
  if [[ $sockets ]]; then
    endpoints=(--commands "ipc://$sockets/commands" --states "ipc://$sockets/states")
  else
    read -r command_port state_port < <(free_ports)
    endpoints=(--commands "tcp://127.0.0.1:$command_port" --states "tcp://127.0.0.1:$state_port")
  fi
  "$acus_bin/acus-server" "$scene" "${endpoints[@]}" "${@:3}" >"$server_log" 2>&1 &
  server=$!
}

# replay_into_server TRAJECTORY LOG [OPTION...]: replays and ends the server; stops waiting at once if the server ends
# first with an error. Lost states are a failure, unless states_may_be_lost is set: then the log tells how many.
replay_into_server() {
  local trajectory=$1 log=$2 ended status=0
  "$acus_bin/acus-replay" "$trajectory" "${endpoints[@]}" --timeout 60 --shutdown "${@:3}" >"$log" &
  replay=$!
  wait -n -p ended "$server" "$replay" || status=$?
  if [[ $ended == "$server" ]]; then
    server=
    ((status == 0)) || fail_with_log "acus-server ended with status $status" "$server_log"
    status=0
    wait_for replay || status=$?
  fi
  replay=
  ((status == 4)) && [[ $states_may_be_lost ]] && status=0
  ((status == 0)) || fail_with_log "acus-replay ended with status $status" "$log" "$server_log"
  [[ -z $server ]] || wait_for server || fail_with_log "acus-server did not end well" "$server_log"
}
