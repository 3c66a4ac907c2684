# SPDX-License-Identifier: GPL-2.0-or-later
"""The software bill names each package that Plumb is built with or runs with, and its licence."""

import json
import os
import re
import subprocess
import sys
import unittest

from plumb_folder import TemporaryFolder
from tree import ROOT

sys.path.insert(0, os.path.join(ROOT, "scripts"))
import software_bill

# Versions of one licence list of SPDX.
LICENCES = {"Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "GPL-2.0-only", "GPL-2.0-or-later", "GPL-3.0-or-later"}
LICENCES |= {"LGPL-2.1-or-later", "MIT", "MPL-2.0", "PSF-2.0", "GCC-exception-3.1"}


def packages_of_setup():
    """Those of the product, in scripts/setup."""
    with open(os.path.join(ROOT, "scripts", "setup"), encoding="utf-8") as file:
        lists = re.findall(r"^(?:packages|for_product)=\(\n(.*?)^\)", file.read(), re.M | re.S)
    return {word for text in lists for line in text.splitlines() for word in line.partition("#")[0].split()}


def packages_of_the_debian_package():
    """Those that debian/control names, and the libraries of the compiler."""
    with open(os.path.join(ROOT, "debian", "control"), encoding="utf-8") as file:
        lists = re.findall(r"^(?:Build-Depends|Depends|Recommends|Suggests):((?:.*\n)(?: .*\n)*)", file.read(), re.M)
    words = {word.strip() for text in lists for word in text.split(",")}
    named = {word.partition(" ")[0].removesuffix("-compat") for word in words if not word.startswith("${")}
    return named | {"libc6", "libgcc-s1", "libstdc++6"}


def bill(*architecture, **environment):
    words = [os.path.join(ROOT, "scripts", "software_bill.py"), "1.2.3", *architecture]
    printed = subprocess.run(words, env={**os.environ, **environment}, capture_output=True, text=True, check=True, timeout=60)
    return json.loads(printed.stdout)


class SoftwareBill(unittest.TestCase):
    def test_every_package_of_the_product_has_its_version_and_a_licence(self):
        found = {each["name"]: each for each in bill()["packages"]}
        self.assertEqual(found.pop("plumb")["versionInfo"], "1.2.3")
        self.assertGreater(len(packages_of_setup()), 15)
        self.assertLessEqual(packages_of_setup(), set(found))
        for package, each in found.items():
            self.assertRegex(each["versionInfo"], r"^[0-9]", package)
            self.assertLessEqual(set(re.split(r" AND | WITH ", each["licenseConcluded"])), LICENCES, package)

    def test_the_table_has_what_setup_and_the_debian_package_name(self):
        self.assertGreater(len(packages_of_the_debian_package()), 25)
        named = [package for package, _, _ in software_bill.table()]
        self.assertEqual(sorted(named), sorted(packages_of_setup() | packages_of_the_debian_package()))

    def test_the_date_is_that_of_the_source(self):
        told = bill(SOURCE_DATE_EPOCH="1700000000")
        self.assertEqual(told["creationInfo"]["created"], "2023-11-14T22:13:20Z")
        self.assertEqual(told, bill(SOURCE_DATE_EPOCH="1700000000"))

    def versions_where_dpkg_query_prints(self, printed, *architecture):
        with TemporaryFolder() as folder:
            path = os.path.join(folder, "dpkg-query")
            with open(path, "w", encoding="utf-8") as file:
                file.write(f"#!/bin/sh\nprintf '{printed}'\n")
            os.chmod(path, 0o755)
            told = bill(*architecture, PATH=folder + ":" + os.environ["PATH"])
        return {each["name"]: each.get("versionInfo") for each in told["packages"]}

    def test_of_packages_for_two_processors_it_names_that_of_the_build(self):
        printed = "installed amd64 4.1-2\\ninstalled arm64 4.1-2+b1\\nconfig-files armhf 4.0\\n"
        self.assertEqual(self.versions_where_dpkg_query_prints(printed, "arm64")["libc6"], "4.1-2+b1")
        self.assertEqual(self.versions_where_dpkg_query_prints(printed, "amd64")["libc6"], "4.1-2")
        self.assertEqual(self.versions_where_dpkg_query_prints("installed all 7\\n", "arm64")["python3-numpy"], "7")

    def test_a_package_that_only_users_install_has_no_version(self):
        found = self.versions_where_dpkg_query_prints("config-files amd64 4.0\\n")
        self.assertIsNone(found["libfaketime"])
        self.assertNotIn("pybind11-dev", found)


if __name__ == "__main__":
    unittest.main()
