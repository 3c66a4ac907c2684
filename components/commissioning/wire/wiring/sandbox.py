# SPDX-License-Identifier: GPL-2.0-or-later
"""Starts a program that can write nothing but a copy of a folder, which stands in the place of this folder.

A program of its own, sandbox.py PLAN COMMAND..., started as the root of a new mount namespace. PLAN is a file of JSON:

    home    the folder of the user
    copy    files that cover the files of this folder and take all that is written there
    own     the files of the trial, which are seen as /run/plumb-wire
    covers  (file, path): the file is seen in the place of the path
    keep    paths that stay in sight in folders that are otherwise empty

All other files can be read and not written. HOME, /tmp, /var/tmp and /run are in memory; HOME shows its files. No socket
of a program outside is in sight. `plumb run`, which the command is, gives it a /dev without devices, and a network,
shared memory and processes of its own.
"""

import ctypes
import json
import os
import re
import resource
import shutil
import stat
import sys

from copies import copy_folder

OWN = "/run/plumb-wire"
HOME = os.environ.get("HOME") or "/"
IN_MEMORY = ("/tmp", "/var/tmp", "/run")
PLAN, READY = "plan.json", "ready"  # files of OWN; the second one comes when the command starts
REWRITTEN = (".tool.mmap", "linuxcnc_debug.txt", "linuxcnc_print.txt")  # files in HOME that each LinuxCNC writes again
COPIED = 1 << 24  # bytes of the files of HOME that a program may change
LONGEST_FILE = 1 << 28  # bytes of a file that the trial writes
KERNEL_SETTINGS = ("sys", "sysrq-trigger", "irq", "bus", "fs", "acpi", "scsi", "mtrr")  # of /proc

# Of Linux 5.12; the numbers are the same on all processors for which LinuxCNC is built.
OPEN_TREE, MOVE_MOUNT, MOUNT_SETATTR = 428, 429, 442
AT_FDCWD, AT_RECURSIVE, OPEN_TREE_CLONE = -100, 0x8000, 1
EMPTY_PATH, FOLLOW_LINKS = 4, 0x10  # of move_mount
READ_ONLY, NO_DEVICES = 1, 4
MS_NOSUID, MS_NODEV, CLONE_NEWUSER = 2, 4, 0x10000000

libc = ctypes.CDLL(None, use_errno=True)


def main():
    if sys.argv[1] == "--inside":
        protect_kernel()
    else:
        with open(sys.argv[1], encoding="utf-8") as file:
            plan = json.load(file)
        furnish(plan)
        os.chdir(plan["home"])
        resource.setrlimit(resource.RLIMIT_FSIZE, (LONGEST_FILE, LONGEST_FILE))
        if os.getuid() == 0 and plan["user"] == 0:
            give_up_the_system()
        with open(os.path.join(OWN, READY), "w", encoding="ascii"):
            pass
    os.execvp(sys.argv[2], sys.argv[2:])


def furnish(plan):
    covers = [(tree(file), path) for file, path in plan["covers"]]
    copy, own, devices, processes = tree(whole(plan)), tree(plan["own"]), tree("/dev"), tree("/proc")
    set_attributes("/", READ_ONLY | NO_DEVICES)
    attach(devices, "/dev")  # plumb run shows the harmless ones
    attach(processes, "/proc")  # which has the rights of processes, and plumb run needs it as it is
    keep = [way(path) for path in (plan["home"], HOME, *plan["keep"]) for way in (os.path.abspath, os.path.realpath)]
    for folder in IN_MEMORY:
        if os.path.isdir(folder) and not os.path.islink(folder):
            empty(folder, keep)
    furnish_home(os.path.realpath(plan["home"]))
    os.mkdir(OWN)
    attach(own, OWN)
    attach(copy, plan["home"])
    for file, path in covers:
        attach(file, path)


def whole(plan):
    """A folder that shows `home`, covered by the files of the copy. The trial writes into the copy."""
    shown, work = (os.path.join(os.path.dirname(plan["copy"]), name) for name in ("shown", "work"))
    for folder in (shown, work):
        os.makedirs(folder, exist_ok=True)
    below = {"lowerdir": plan["home"], "upperdir": plan["copy"], "workdir": work}
    options = ",".join("%s=%s" % (name, re.sub(r"([\\:,])", r"\\\1", path)) for name, path in below.items())
    if plan["user"] != 0:
        options += ",userxattr"
    if libc.mount(b"plumb-wire", os.fsencode(shown), b"overlay", ctypes.c_ulong(0), os.fsencode(options)) == 0:
        return shown
    shutil.rmtree(shown)  # this file system cannot lie below another one
    copy_folder(plan["home"], shown)
    shutil.copytree(plan["copy"], shown, dirs_exist_ok=True)
    return shown


def empty(folder, keep):
    """Makes a folder empty but for what leads to these paths."""
    names = {os.path.relpath(path, folder).split(os.sep)[0] for path in keep if below(path, folder)}
    replace(folder, [name for name in sorted(names) if os.path.lexists(os.path.join(folder, name))], "mode=1777")


def furnish_home(home):
    """A HOME in memory, unless it is the copy or lies in it."""
    folder = os.path.realpath(HOME)
    if folder != "/" and os.path.isdir(folder) and folder != home and not below(folder, home):
        names = [name for name in sorted(os.listdir(folder)) if name not in REWRITTEN]
        replace(folder, names, "mode=0700", COPIED)


def replace(folder, names, mode, budget=0):
    """Mounts an empty folder that shows these files and folders of the one before. The first files, of `budget` bytes in
    all, are copies."""
    shown, files = [], {}
    for name in names:
        path = os.path.join(folder, name)
        try:
            state = os.lstat(path)
            if stat.S_ISLNK(state.st_mode):
                shown.append((name, os.readlink(path)))
            elif stat.S_ISREG(state.st_mode) and state.st_size <= budget:
                with open(path, "rb") as file:
                    files[name] = file.read(), state.st_mode & 0o777
                budget -= state.st_size
            elif stat.S_ISREG(state.st_mode) or stat.S_ISDIR(state.st_mode):
                shown.append((name, tree(path)))
        except OSError:  # which the program could not read either
            continue
    call(libc.mount, b"plumb-wire", os.fsencode(folder), b"tmpfs", ctypes.c_ulong(MS_NOSUID | MS_NODEV), mode.encode())
    for name, seen in shown:
        path = os.path.join(folder, name)
        if isinstance(seen, str):
            os.symlink(seen, path)
            continue
        if stat.S_ISDIR(os.fstat(seen).st_mode):
            os.mkdir(path)
        else:
            os.close(os.open(path, os.O_CREAT | os.O_WRONLY, 0o600))
        attach(seen, path)
    for name, (data, mode) in files.items():
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)
            os.fchmod(file.fileno(), mode)


def give_up_the_system():
    """Root keeps its rights over files and loses all others over the computer. In a user namespace of its own it cannot
    take back what was mounted."""
    maps = {}
    for name in ("uid_map", "gid_map"):
        with open("/proc/self/" + name, encoding="ascii") as file:
            maps[name] = "".join("%s %s %s\n" % (first, first, count) for first, _, count in map(str.split, file))
    ready, go = os.pipe()
    parent, child = os.getpid(), os.fork()
    if child == 0:  # it is still outside, where the maps can be written
        os.close(go)
        os.read(ready, 1)
        for name, text in maps.items():
            with open("/proc/%d/%s" % (parent, name), "w", encoding="ascii") as file:
                file.write(text)
        os._exit(0)
    os.close(ready)
    call(libc.unshare, ctypes.c_int(CLONE_NEWUSER))
    os.close(go)
    if os.waitpid(child, 0)[1] != 0:
        raise OSError("a user namespace of its own was refused")


def protect_kernel():
    """In the namespaces of plumb run, whose /proc is a new one: root could change settings of the kernel there."""
    for name in KERNEL_SETTINGS:
        path = "/proc/" + name
        if os.path.exists(path):
            seen = tree(path)
            attach(seen, path)
            set_attributes(path, READ_ONLY)


def below(path, folder):
    return path.startswith(folder.rstrip("/") + "/")


def tree(path):
    """A descriptor of the file or folder at a path, with the rights that it has now, to be attached elsewhere."""
    flags = ctypes.c_uint(OPEN_TREE_CLONE | os.O_CLOEXEC | AT_RECURSIVE)
    return system(OPEN_TREE, ctypes.c_int(AT_FDCWD), os.fsencode(path), flags, path=path)


def attach(descriptor, path):
    flags = ctypes.c_uint(EMPTY_PATH | FOLLOW_LINKS)
    system(MOVE_MOUNT, ctypes.c_int(descriptor), b"", ctypes.c_int(AT_FDCWD), os.fsencode(path), flags, path=path)
    os.close(descriptor)


def set_attributes(path, attributes):
    """For all that is mounted at or below a path."""
    wanted = (ctypes.c_uint64 * 4)(attributes, 0, 0, 0)
    recursive, size = ctypes.c_uint(AT_RECURSIVE), ctypes.c_size_t(ctypes.sizeof(wanted))
    system(MOUNT_SETATTR, ctypes.c_int(AT_FDCWD), os.fsencode(path), recursive, wanted, size, path=path)


def system(number, *arguments, path=None):
    return call(libc.syscall, ctypes.c_long(number), *arguments, path=path)


def call(function, *arguments, path=None):
    result = function(*arguments)
    if result < 0:
        error = ctypes.get_errno()
        raise OSError(error, os.strerror(error), path)
    return result


if __name__ == "__main__":
    try:
        main()
    except OSError as error:
        sys.exit("plumb wire: the trial cannot be kept apart: %s" % error)
