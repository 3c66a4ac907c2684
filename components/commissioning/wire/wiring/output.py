# SPDX-License-Identifier: GPL-2.0-or-later
"""The folder that plumb wire writes: which files are its own, and which a user has changed."""

import contextlib
import difflib
import hashlib
import json
import os
import re

import writing
from ini_file import IniFile
from numbers_of_programs import SECTION
from texts import Impossible, wrapped

MANIFEST = ".written.json"  # the digest of each file that was written
SETTINGS = "_settings.hal"
KEPT = (SETTINGS, "panel.toml", "growth.toml")  # the ends of names of files that the user changes
NUMBERS = re.compile(r"\n*^\[%s\][^\[]*" % SECTION, re.M)
MOST_SHOWN = 20  # lines of a file that has changed


class Output:
    """The folder of one INI file, which lies below `home`.

    functions   names of the functions that are wired in it
    kept        files of the user, which are not written
    """

    def __init__(self, folder, home, ini_name, version=""):
        self.folder, self.home, self.ini_name, self.version = folder, home, ini_name, version
        self._forbid_links()
        self.kept = []
        self._forbid_read_only()
        self.manifest = self._manifest()
        self.functions = self.manifest.get("functions", [])

    def _forbid_links(self):
        """By a link, files would be written elsewhere."""
        path = self.home
        for part in os.path.relpath(self.folder, self.home).split(os.sep):
            path = os.path.join(path, part)
            if os.path.islink(path):
                raise Impossible("%s is a link. Name another folder by --output." % path)

    def _forbid_read_only(self):
        """Reports it before the trials, which take their time."""
        path = self.folder
        while path != self.home and not os.path.lexists(path):
            path = os.path.dirname(path)
        if os.path.isdir(path) and not os.access(path, os.W_OK | os.X_OK):
            sentence = "You cannot write into %s. Copy the configuration into a folder of yours, or change its rights."
            raise Impossible(wrapped(sentence % path))

    def _manifest(self):
        with contextlib.suppress(FileNotFoundError, NotADirectoryError):
            text = writing.read(self.folder, MANIFEST)
            if text is not None:
                return self._checked(text)
        if os.path.exists(self.folder) and not os.path.isdir(self.folder):
            raise Impossible("%s is a file. Name another folder by --output." % self.folder)
        present = os.listdir(self.folder) if os.path.isdir(self.folder) else []
        files = sorted(name for name in present if not writing.STAGED.fullmatch(name))
        if files:
            sentence = "%s exists, and plumb wire did not write it: it has %s. Name another folder by --output."
            raise Impossible(wrapped(sentence % (self.folder, ", ".join(files[:5]))))
        return {}

    def _checked(self, text):
        """The manifest: the name of the INI file, the functions, and for each file a digest, or two while it is replaced."""
        try:
            manifest = json.loads(text)
            ini, functions, files = manifest["ini"], manifest["functions"], manifest["files"]
            texts = [ini, *functions, *files]
            for its in files.values():
                texts += [its] if isinstance(its, str) else its
            if not isinstance(functions, list) or not all(isinstance(one, str) for one in [*texts, manifest.get("version", "")]):
                raise TypeError
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            sentence = (
                "%s, in which plumb wire notes its files, is damaged. Restore it, or move the folder away and wire all functions "
                "again. Settings that you changed are in the files %s."
            )
            raise Impossible(wrapped(sentence % (os.path.join(self.folder, MANIFEST), "*" + SETTINGS))) from None
        if ini != self.ini_name:
            raise Impossible("%s belongs to %s. Name another folder by --output." % (self.folder, ini))
        return manifest

    def _digests(self, name):
        """Of the texts that plumb wire gave to a file. There are two after a start that was interrupted."""
        its = self.manifest.get("files", {}).get(name, [])
        return [its] if isinstance(its, str) else its

    def present(self, name):
        """The text of a file that is there, or None."""
        return writing.read(self.folder, name, follow=name.endswith(SETTINGS))

    def changed(self, name):
        """The text of a file that a user has changed, or None."""
        text = self.present(name)
        return None if text is None or digest(text) in self._digests(name) else text

    def inc(self, values, numbers):
        """plumb.inc: the present text with the values that it lacks, and the section of the numbers, which is written again."""
        text = self.present("plumb.inc")
        if text is None:
            text = "# SPDX-License-Identifier: GPL-2.0-or-later\n# Values of the functions that plumb wire put in.\n"
        text = NUMBERS.sub("", text)
        path = os.path.join(self.folder, "plumb.inc")
        old = IniFile(path) if os.path.exists(path) else None
        lacking = {}
        for (section, name), value in values.items():
            if section != SECTION and not (old and old.get(section, name) is not None):
                lacking.setdefault(section, []).append("%s = %s\n" % (name, value))
        for section, lines in lacking.items():
            head = re.search(r"^\[%s\].*\n" % re.escape(section), text, re.M)
            if head:
                text = text[: head.end()] + "".join(lines) + text[head.end() :]
            else:
                text += "\n[%s]\n%s" % (section, "".join(lines))
        if numbers:
            lines = ["%s = %s\n" % item for item in numbers.items()]
            text += "\n[%s]\n# Outputs and inputs of M62 to M68. Wire again when you change one.\n%s" % (SECTION, "".join(lines))
        return text

    def forbid_strangers(self, files):
        """Refuses to write over a file that a user has changed; settings are the user's to change."""
        changed = [
            name
            for name, text in files.items()
            if not name.endswith((*KEPT, ".inc")) and self.changed(name) not in (None, text)
        ]
        if changed:
            sentence = (
                "Somebody changed %s in %s after plumb wire wrote it. Move the changes into a HALFILE of your own, behind "
                "plumb.hal, and remove the file; then wire again."
            )
            raise Impossible(wrapped(sentence % (", ".join(changed), self.folder)))

    def is_kept(self, name):
        """Whether these are settings that a user has changed."""
        return name.endswith(KEPT) and self.changed(name) is not None

    def write(self, files, functions):
        """All files at once, or none. While they are replaced the manifest has the digests of both texts: if that is interrupted,
        no file is taken for one of the user."""
        written, between, texts = {}, dict(self.manifest.get("files", {})), []
        for name, text in files.items():
            if self.is_kept(name):
                self.kept.append(name)
                written[name] = self._digests(name)
            else:
                texts.append((name, text))
                written[name] = digest(text)
                between[name] = list(dict.fromkeys([*self._digests(name), digest(text)]))
        texts.insert(0, (MANIFEST, self._manifest_text(self.functions, between)))
        stale = {name: its for name, its in self.manifest.get("files", {}).items() if name not in files}
        left = {name: its for name, its in stale.items() if self.changed(name) is not None}
        slots = [""] * (1 + max((function.number for function in functions), default=-1))
        for function in functions:
            slots[function.number] = function.name
        texts.append((MANIFEST, self._manifest_text(slots, {**left, **written})))
        folder = os.path.relpath(self.folder, self.home)
        writing.write_all(self.home, [(os.path.join(folder, name), text) for name, text in texts], lasting=True)
        for name in set(stale) - set(left):
            with contextlib.suppress(OSError):
                os.unlink(os.path.join(self.folder, name))
        writing.remove_staged(self.folder)

    def forget(self):
        """No function is wired any more; the files stay."""
        text = self._manifest_text([], self.manifest.get("files", {}))
        writing.write(self.folder, MANIFEST, text)

    def differences(self, files):
        """A sentence for each file that differs from `files`, which this Plumb writes for the machine as it is now."""
        found = []
        version = self.manifest.get("version")
        if version != self.version:
            found.append("Plumb %s wired them, and this is Plumb %s." % (version or "of before", self.version))
        for name, text in files.items():
            if name == "ini.patch" or name.endswith((*KEPT, ".inc")):
                continue
            present = self.present(name)
            if present is None:
                found.append("%s is missing." % name)
            elif self.changed(name) is not None:
                found.append("%s: somebody changed it." % name)
            elif present != text:
                lines = difflib.unified_diff(present.splitlines(), text.splitlines(), lineterm="", n=0)
                shown = [line for line in lines if not line.startswith(("---", "+++", "@@"))]
                found.append("%s would be another:\n%s" % (name, "\n".join("    " + line for line in shown[:MOST_SHOWN])))
        return found

    def _manifest_text(self, functions, files):
        manifest = {"ini": self.ini_name, "version": self.version, "functions": functions, "files": files}
        return json.dumps(manifest, indent=1) + "\n"


def digest(text):
    return hashlib.sha256(text.encode("utf-8", "surrogateescape")).hexdigest()
