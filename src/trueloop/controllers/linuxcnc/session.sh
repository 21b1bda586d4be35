# One headless LinuxCNC in namespaces of its own; run by session.py as  bash session.sh FOLDER, as root of the namespaces.
# Private are the network's loopback (NML), shared memory, process numbers, /tmp (lock files) and LinuxCNC's module
# folder, over which FOLDER/modules is laid.
set -euo pipefail
ip link set lo up
mount --bind "$1" /mnt
mount -t tmpfs tmpfs /tmp
mkdir -p "$1"
mount --bind /mnt "$1"
mount -t overlay overlay -o lowerdir="$1/modules":/usr/lib/linuxcnc/modules /usr/lib/linuxcnc/modules
cd "$1/config"
exec linuxcnc -r machine.ini </dev/null
