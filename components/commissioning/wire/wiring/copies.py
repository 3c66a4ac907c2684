# SPDX-License-Identifier: GPL-2.0-or-later
"""Copies of a folder of the user."""

import contextlib
import os
import pathlib
import shutil
import stat


def copy_folder(source, copy):
    """Links to files become files, as they might be written to; links to folders stay. What cannot be read is left out:
    LinuxCNC cannot read it either. So is a folder for temporary files, in which the copy lies."""
    os.mkdir(copy)
    for entry, there in entries_below(source, copy):
        if entry.is_dir(follow_symlinks=False):
            os.mkdir(there)
        elif entry.is_dir():
            os.symlink(os.readlink(entry.path), there)
        elif entry.is_file():
            copy_file(entry, there)


def copy_links(source, copy):
    """Files in the place of links to files, as they might be written to, and nothing else."""
    os.mkdir(copy)
    for entry, there in entries_below(source, copy):
        if entry.is_symlink() and entry.is_file():
            os.makedirs(os.path.dirname(there), exist_ok=True)
            copy_file(entry, there)
    for folder, _, _ in os.walk(copy):
        shutil.copymode(os.path.join(source, os.path.relpath(folder, copy)), folder)


def entries_below(source, copy):
    """Each file and folder, and its place in the copy; without a folder in which the copy lies."""
    folders = [(source, copy)]
    above = {(state.st_dev, state.st_ino) for state in map(os.stat, pathlib.Path(copy).absolute().parents)}
    while folders:
        folder, to = folders.pop()
        with contextlib.suppress(PermissionError), os.scandir(folder) as entries:
            for entry in entries:
                there = os.path.join(to, entry.name)
                state = entry.stat(follow_symlinks=False)
                if (state.st_dev, state.st_ino) in above:
                    continue
                yield entry, there
                if entry.is_dir(follow_symlinks=False):
                    folders.append((entry.path, there))


def copy_file(entry, to):
    with contextlib.suppress(PermissionError):
        shutil.copyfile(entry.path, to)
        state = entry.stat()
        os.chmod(to, stat.S_IMODE(state.st_mode) & 0o777 | stat.S_IWUSR)
        os.utime(to, ns=(state.st_atime_ns, state.st_mtime_ns))
