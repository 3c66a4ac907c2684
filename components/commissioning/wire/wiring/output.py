# SPDX-License-Identifier: GPL-2.0-or-later
"""The folder that plumb wire writes: which files are its own, and which a user has changed."""

import contextlib
import hashlib
import json
import os

from ini_file import IniFile
from texts import Impossible, wrapped

MANIFEST = ".written.json"  # the digest of each file that was written


class Output:
    """The folder of one INI file.

    functions   names of the functions that are wired in it
    kept        files of the user, which are not written
    """

    def __init__(self, folder, ini_name):
        self.folder, self.ini_name = folder, ini_name
        self.kept = []
        self.manifest = self._manifest()
        self.functions = self.manifest.get("functions", [])

    def _manifest(self):
        with contextlib.suppress(FileNotFoundError, NotADirectoryError, ValueError):
            with open(os.path.join(self.folder, MANIFEST), encoding="utf-8") as file:
                manifest = json.load(file)
            if manifest["ini"] != self.ini_name:
                raise Impossible("%s belongs to %s. Name another folder by --output." % (self.folder, manifest["ini"]))
            return manifest
        if os.path.exists(self.folder) and not os.path.isdir(self.folder):
            raise Impossible("%s is a file. Name another folder by --output." % self.folder)
        files = sorted(os.listdir(self.folder)) if os.path.isdir(self.folder) else []
        if files:
            sentence = "%s exists, and plumb wire did not write it: it has %s. Name another folder by --output."
            raise Impossible(wrapped(sentence % (self.folder, ", ".join(files[:5]))))
        return {}

    def present(self, name):
        """The text of a file that is there, or None."""
        with contextlib.suppress(FileNotFoundError):
            with open(os.path.join(self.folder, name), encoding="utf-8", errors="surrogateescape") as file:
                return file.read()
        return None

    def changed(self, name):
        """The text of a file that a user has changed, or None."""
        text = self.present(name)
        return None if text is None or digest(text) == self.manifest.get("files", {}).get(name) else text

    def values(self, functions):
        """(section, name) -> value, of the plumb.inc that is there."""
        path = os.path.join(self.folder, "plumb.inc")
        old = IniFile(path) if os.path.exists(path) else None
        return {
            (section, name): old.get(section, name) if old else None
            for function in functions
            for section, names in function.ini.items()
            for name in names
        }

    def inc(self, functions):
        """plumb.inc: the present text, and the sections that it lacks."""
        text = self.present("plumb.inc")
        if text is None:
            text = "# SPDX-License-Identifier: GPL-2.0-or-later\n# Values of the functions that plumb wire put in.\n"
        there = {section for (section, _), value in self.values(functions).items() if value is not None}
        for function in functions:
            for section, values in function.ini.items():
                if section not in there:
                    lines = ["%s = %s\n" % item for item in values.items()]
                    text += "\n[%s]\n%s" % (section, "".join(lines))
        return text

    def forbid_strangers(self, files):
        """Refuses to write over a file that a user has changed; settings are the user's to change."""
        changed = [
            name
            for name, text in files.items()
            if not name.endswith(("_settings.hal", ".inc")) and self.changed(name) not in (None, text)
        ]
        if changed:
            sentence = (
                "Somebody changed %s in %s after plumb wire wrote it. Move the changes into a HALFILE of your own, behind "
                "plumb.hal, and remove the file; then wire again."
            )
            raise Impossible(wrapped(sentence % (", ".join(changed), self.folder)))

    def is_kept(self, name):
        """Whether these are settings that a user has changed."""
        return name.endswith("_settings.hal") and self.changed(name) is not None

    def write(self, files, functions):
        """Each file at once, whole or not at all."""
        os.makedirs(self.folder, exist_ok=True)
        written = {}
        for name, text in files.items():
            if self.is_kept(name):
                self.kept.append(name)
                written[name] = self.manifest.get("files", {}).get(name, "")
            else:
                _write_whole(os.path.join(self.folder, name), text)
                written[name] = digest(text)
        manifest = {"ini": self.ini_name, "functions": [function.name for function in functions], "files": written}
        _write_whole(os.path.join(self.folder, MANIFEST), json.dumps(manifest, indent=1) + "\n")


def digest(text):
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()


def _write_whole(path, text):
    new = path + ".new"
    with open(new, "w", encoding="utf-8", errors="surrogateescape") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(new, path)
