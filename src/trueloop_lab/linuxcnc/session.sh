# One headless LinuxCNC in namespaces of its own; run by session.py as  bash session.sh FOLDER, as root of the namespaces.
# Private are the network's loopback (NML), shared memory, process numbers, LinuxCNC's own files in /tmp (its lock, its
# logs) and its module folder, over which FOLDER/modules is laid.
set -euo pipefail
ip link set lo up

# A new /tmp in which every entry of the old one is a link to it: programs, environments and results that lie there are
# found and written as everywhere else. LinuxCNC's lock of a session outside must not be found. FOLDER is there as
# .session: LinuxCNC's real-time process is nobody's, and may not pass through folders that are its user's alone.
mkdir -p "$1/tmp" # a session of the same folder may have left it
mount -t tmpfs tmpfs "$1/tmp"
mkdir "$1/tmp/.outside" "$1/tmp/.session"
mount --bind "$1" "$1/tmp/.session"
mount --rbind /tmp "$1/tmp/.outside"
mount --rbind "$1/tmp" /tmp
cd /tmp
# The shell's own pattern reads names alone: `find` looks at each entry, and fails where another process removes it.
shopt -s dotglob nullglob
for entry in .outside/*; do
    case $entry in .outside/linuxcnc.*) ;; *) printf '%s\0' "$entry" ;; esac
done | xargs -0 -r ln -s -t .

mount -t overlay overlay -o lowerdir=/tmp/.session/modules:/usr/lib/linuxcnc/modules /usr/lib/linuxcnc/modules
export HOME=/tmp/.session/home RTAPI_FIFO_PATH=/tmp/.session/home/rtapi_fifo
cd "$1/config" # the configuration has one path, inside and outside: by it a session's processes are found
exec linuxcnc -r "$1/config/machine.ini" </dev/null
