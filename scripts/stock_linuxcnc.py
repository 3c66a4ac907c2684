# SPDX-License-Identifier: GPL-2.0-or-later
"""Programs with LinuxCNC's own realtime side, closed in: they do not meet a machine that runs, nor each other."""

# As the root of new namespaces: a network of its own, and a private /tmp, in which a folder stays where it is.
# The program itself runs as an ordinary user, for whom rtapi_app needs neither privileges nor a named user.
_FURNISH = """
set -e
ip link set lo up
here=$PWD folder=$1
cd "$folder"
mount -t tmpfs -o mode=1777 tmpfs /tmp
mount -t tmpfs -o mode=1777 tmpfs /dev/shm
mkdir -p /tmp/home "$folder"
mount --no-canonicalize --bind . "$folder"
cd "$here"
shift
exec unshare --user --map-user=1000 --map-group=1000 -- "$@"
"""

_SPACES = ["--user", "--map-root-user", "--ipc", "--net", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc"]

ENVIRONMENT = {"HOME": "/tmp/home", "PATH": "/usr/bin:/bin:/usr/sbin:/sbin", "LC_ALL": "C"}


def closed_in(program, folder):
    """The command that runs a program closed in, in ENVIRONMENT, and in or below the folder.

    SIGKILL ends it with all that it started, and so does the end of the thread that starts it.
    """
    return ["setpriv", "--pdeathsig", "KILL", "unshare", *_SPACES, "--", "/bin/sh", "-c", _FURNISH, "sh", folder, *program]
