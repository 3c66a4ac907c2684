# SPDX-License-Identifier: GPL-2.0-or-later
"""Files beside the INI file. A link would lead into another file: none is followed. Without a screen."""

import errno
import os
import tempfile

from panel.texts import _


def open_own(path, mode):
    """Opens a file, or makes it. Raises OSError, also for a link, a pipe or a device."""
    refuse_link(path)
    return open(path, mode, opener=lambda path, flags: os.open(path, flags | os.O_NOFOLLOW | os.O_NONBLOCK, 0o666))


def replace(path, text, encoding="utf-8", like=None):
    """Puts a new file in the place of a file, whole or not at all. Raises OSError, also for a link. `like` is an os.stat() whose owner and
    mode it gets."""
    refuse_link(path)
    folder, name = os.path.split(os.path.abspath(path))
    with tempfile.NamedTemporaryFile("w", dir=folder, prefix=".%s-" % name, delete=False, encoding=encoding, errors="surrogateescape",
                                     newline="") as file:
        try:
            file.write(text)
            file.flush()
            if like is not None:
                os.fchown(file.fileno(), like.st_uid, like.st_gid)
            os.fchmod(file.fileno(), like.st_mode & 0o7777 if like is not None else 0o644)
            os.fsync(file.fileno())
            os.replace(file.name, path)
        except OSError as error:
            os.unlink(file.name)
            raise OSError(error.errno, error.strerror, path) from None


def refuse_link(path):
    if os.path.islink(path):
        raise OSError(errno.ELOOP, _("it is a link, which is not followed"), path)
