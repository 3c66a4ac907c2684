# SPDX-License-Identifier: GPL-2.0-or-later
"""The one way in which plumb wire writes a file: below a folder of its own, whole or not at all, and through no link."""

import contextlib
import errno
import os
import re
import secrets
import stat

from texts import Impossible

FOLDER = os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC
STAGED = re.compile(r"\.[0-9a-f]{16}\.new")  # files that are not in their places yet; a killed program leaves them
NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC


class PartlyWritten(RuntimeError):
    """Some files are new, and some are old. `cause` is the error."""

    def __init__(self, cause):
        super().__init__(str(cause))
        self.cause = cause


def write_all(root, texts, mode=0o666, lasting=False):
    """Writes each text into its file below `root`, in this order. The files change together, once all of them are on the disk.

    texts       names and texts; a name may come twice
    lasting     whether they must survive a failure of power
    """
    with contextlib.ExitStack() as stack:
        staged, made, folders, placed = [], [], set(), 0
        try:
            for name, text in texts:
                folder = _folder_of(root, name, stack, made)
                if os.path.isdir(os.path.join(root, name)):
                    raise Impossible("%s is a folder, and plumb wire writes a file of this name." % os.path.join(root, name))
                new = ".%s.new" % secrets.token_hex(8)
                folders.add(folder)
                file = os.open(new, NEW, mode, dir_fd=folder)
                staged.append((folder, new, name))
                with open(file, "w", encoding="utf-8", errors="surrogateescape", newline="") as stream:
                    stream.write(text)
                    stream.flush()
                    if lasting:
                        os.fsync(file)
            while staged:
                folder, new, name = staged[0]
                os.rename(new, os.path.basename(name), src_dir_fd=folder, dst_dir_fd=folder)
                del staged[0]
                placed += 1
            if lasting:
                for folder in folders:
                    _sync(folder)
        except BaseException as error:
            for folder, new, _ in staged:
                with contextlib.suppress(OSError):
                    os.unlink(new, dir_fd=folder)
            if isinstance(error, OSError):
                error.filename, error.filename2 = os.path.join(root, name), None
                if placed:
                    raise PartlyWritten(error) from error
            for folder, part in reversed(made):
                with contextlib.suppress(OSError):  # it has a file by now
                    os.rmdir(part, dir_fd=folder)
            raise


def write(root, name, text, mode=0o666):
    write_all(root, [(name, text)], mode)


def rewrite(path, text):
    """Gives a file of the user another text, whole or not at all. Its owner and rights stay."""
    folder = os.path.dirname(path)
    new = os.path.join(folder, ".%s.new" % secrets.token_hex(8))
    state = os.stat(path)
    try:
        with open(os.open(new, NEW, 0o600), "w", encoding="utf-8", errors="surrogateescape", newline="") as stream:
            stream.write(text)
            stream.flush()
            with contextlib.suppress(PermissionError):
                os.fchown(stream.fileno(), state.st_uid, state.st_gid)
            os.fchmod(stream.fileno(), stat.S_IMODE(state.st_mode))
            os.fsync(stream.fileno())
        os.rename(new, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(new)
        raise


def _sync(folder):
    descriptor = os.open(".", os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC, dir_fd=folder)
    try:
        os.fsync(descriptor)
    except OSError as error:
        if error.errno != errno.EINVAL:  # of a file system that syncs no folder
            raise
    finally:
        os.close(descriptor)


def remove_staged(folder):
    """Removes the files that a killed program has left."""
    for name in os.listdir(folder):
        if STAGED.fullmatch(name):
            with contextlib.suppress(OSError):
                os.unlink(os.path.join(folder, name))


def _folder_of(root, name, stack, made):
    """A descriptor of the folder of a file below `root`. Folders that are not there are made, and added to `made`."""

    def opened(path, flags=0, **where):
        descriptor = os.open(path, FOLDER | flags, **where)
        stack.callback(os.close, descriptor)
        return descriptor

    parts = name.split("/")
    if not all(part not in ("", ".", "..") for part in parts):
        raise Impossible("plumb wire writes nothing outside %s, and %s leads out of it." % (root, name))
    folder = opened(root)
    for number, part in enumerate(parts[:-1], start=1):
        with contextlib.suppress(FileExistsError):
            os.mkdir(part, dir_fd=folder)
            made.append((folder, part))
        try:
            folder = opened(part, os.O_NOFOLLOW, dir_fd=folder)
        except NotADirectoryError:
            place = os.path.join(root, *parts[:number])
            raise Impossible("plumb wire writes through no link: %s must be a folder." % place) from None
    return folder


def read(root, name, follow=False):
    """The text of a file below `root`; None if there is none. Without `follow`, a link is refused."""
    path = os.path.join(root, name)
    try:
        file = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK | (0 if follow else os.O_NOFOLLOW))
    except FileNotFoundError:
        return None
    except OSError:
        if not follow and os.path.islink(path):
            raise Impossible("%s is a link. Put the file itself there." % path) from None
        raise
    with open(file, encoding="utf-8", errors="surrogateescape", newline="") as stream:
        return stream.read()


def inside(path, folder):
    """The name of a file below a folder, by the folders to which links lead; None if the file lies elsewhere."""
    place = os.path.join(os.path.realpath(os.path.dirname(path)), os.path.basename(path))
    name = os.path.relpath(place, os.path.realpath(folder))
    return None if name.split(os.sep)[0] in ("..", ".") else name
