# SPDX-License-Identifier: GPL-2.0-or-later
"""scripts/setup on machines that lack something, played by stand-ins for the package tools."""

import os
import shutil
import subprocess
import unittest

from tree import ROOT, own_folder

NOBODY = 65534


class Setup(unittest.TestCase):
    """A checkout with scripts/setup alone, and a machine whose only programs are stand-ins that keep a log."""

    def setUp(self):
        self.root = own_folder(self)
        os.chmod(self.root, 0o755)
        self.log = os.path.join(self.root, "log")
        open(self.log, "w").close()
        os.chmod(self.log, 0o666)
        for name in ("scripts", "bin"):
            os.mkdir(os.path.join(self.root, name))
        shutil.copy(os.path.join(ROOT, "scripts", "setup"), os.path.join(self.root, "scripts"))
        for tool in ("bash", "dirname", "env", "grep", "nproc"):
            os.symlink(shutil.which(tool), os.path.join(self.root, "bin", tool))
        for tool in ("apt-get", "cmake"):
            self.program(tool, "true")
        self.program("apt-cache", 'echo "$2 | 1.0 | somewhere"', logged=False)

    def program(self, name, script, logged=True):
        path = os.path.join(self.root, "bin", name)
        with open(path, "w", encoding="ascii") as file:
            file.write("#!/bin/bash\n")
            if logged:
                file.write(f'echo "{name} $*" >>{self.log}\n')
            file.write(script + "\n")
        os.chmod(path, 0o755)

    def lack(self, *packages):
        """The machine has every package but these."""
        lacking = "|".join(packages) or "-"
        script = f'for p in "${{@:3}}"; do case $p in {lacking}) ;; *) echo "installed $p" ;; esac; done'
        self.program("dpkg-query", script, logged=False)

    def setup_as(self, user, *arguments):
        become = (lambda: os.setuid(user)) if os.geteuid() == 0 and user else None
        return subprocess.run(
            [os.path.join(self.root, "scripts", "setup"), *arguments],
            env={"PATH": os.path.join(self.root, "bin")},
            preexec_fn=become,
            capture_output=True,
            text=True,
            timeout=30,
        )

    def log_anew(self):
        open(self.log, "w").close()

    def calls(self):
        with open(self.log, encoding="ascii") as file:
            return file.read().splitlines()

    def test_nothing_missing_needs_no_root_and_no_apt(self):
        self.lack()
        done = self.setup_as(NOBODY)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([call.split()[0] for call in self.calls()], ["cmake", "cmake"])

    def test_without_root_and_sudo_it_names_the_package_to_install(self):
        self.lack("cmake", "linuxcnc-uspace")
        done = self.setup_as(NOBODY)
        self.assertEqual(done.returncode, 1)
        self.assertIn("missing: linuxcnc-uspace cmake", done.stderr)
        self.assertIn("root", done.stderr)
        self.assertEqual(self.calls(), [])

    def test_with_sudo_exactly_what_is_missing_is_installed(self):
        self.lack("cmake", "mandoc")
        self.program("sudo", '"$@"', logged=False)
        done = self.setup_as(NOBODY)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(
            self.calls()[:2],
            ["apt-get update -q", "apt-get install -q -y --no-install-recommends cmake mandoc"],
        )

    @unittest.skipUnless(os.geteuid() == 0, "not root")
    def test_root_needs_no_sudo(self):
        self.lack("mandoc")
        done = self.setup_as(0)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("apt-get install -q -y --no-install-recommends mandoc", self.calls())

    @unittest.skipUnless(os.geteuid() == 0, "not root")
    def test_further_packages_are_installed_for_who_asks(self):
        self.lack("faketime", "man-db")
        done = self.setup_as(0, "--with", "iproute2 faketime", "product")
        self.assertEqual(done.returncode, 0, done.stderr)
        calls = self.calls()
        self.assertIn("apt-get install -q -y --no-install-recommends faketime man-db", calls)
        self.assertTrue(calls[-1].endswith("--target product"), calls)

    def test_product_needs_no_package_of_the_tests(self):
        self.lack("libgtest-dev", "libgmock-dev", "librapidcheck-dev", "libbenchmark-dev", "xvfb")
        done = self.setup_as(NOBODY, "product")
        self.assertEqual(done.returncode, 0, done.stderr)
        configured, built = self.calls()
        self.assertIn("-DBUILD_TESTING=OFF", configured)
        self.assertTrue(built.endswith("--target product"), built)
        self.log_anew()
        self.assertIn("libgtest-dev", self.setup_as(NOBODY).stderr)

    def test_simulation_needs_no_package_of_the_panel_the_programs_and_the_tests(self):
        self.lack("gir1.2-gtk-3.0", "gettext", "libtomlplusplus-dev", "libmodbus-dev", "man-db", "python3-canmatrix", "librsvg2-bin", "libgtest-dev")
        done = self.setup_as(NOBODY, "simulation_growth", "plumb-growth")
        self.assertEqual(done.returncode, 0, done.stderr)
        configured, built = self.calls()
        self.assertIn("-DBUILD_PRODUCT=OFF -DBUILD_TESTING=OFF", configured)
        self.assertTrue(built.endswith("--target simulation_growth plumb-growth"), built)
        self.log_anew()
        missing = self.setup_as(NOBODY, "product").stderr
        self.assertIn("libtomlplusplus-dev", missing)
        self.assertIn("libmodbus-dev", missing)

    def test_what_a_folder_leaves_out_is_added_when_it_is_needed(self):
        self.lack()
        os.mkdir(os.path.join(self.root, "build"))
        os.chmod(os.path.join(self.root, "build"), 0o755)
        product, testing = "-DBUILD_PRODUCT=ON", "-DBUILD_TESTING=ON"
        for folder, target, added in (
            ("OFF OFF", "simulation_mill", ""),
            ("OFF OFF", "product", product),
            ("OFF OFF", "all", f"{product} {testing}"),
            ("ON OFF", "product", ""),
            ("ON OFF", "all", testing),
            ("ON ON", "all", ""),
            ("ON ON", "product", ""),
            ("ON ON", "simulation_mill", ""),
        ):
            cache = "BUILD_PRODUCT:BOOL={}\nBUILD_TESTING:BOOL={}\n".format(*folder.split())
            for name, text in (("build.ninja", ""), ("CMakeCache.txt", cache)):
                with open(os.path.join(self.root, "build", name), "w", encoding="ascii") as file:
                    file.write(text)
            self.log_anew()
            done = self.setup_as(NOBODY, target)
            self.assertEqual(done.returncode, 0, done.stderr)
            *configured, built = self.calls()
            self.assertEqual(configured, [f"cmake -S . -B build {added}"] if added else [], (folder, target))
            self.assertTrue(built.endswith(f"--target {target}"), built)

    def test_sanitized_build_has_a_folder_of_its_own(self):
        self.lack()
        done = self.setup_as(NOBODY, "--sanitize")
        self.assertEqual(done.returncode, 0, done.stderr)
        configured, built = self.calls()
        self.assertIn("-B build-sanitize", configured)
        self.assertIn("-DPLUMB_SANITIZE=address,undefined", configured)
        self.assertIn("--build build-sanitize ", built)

    def test_package_that_this_system_does_not_have_is_named(self):
        self.lack("linuxcnc-uspace", "cmake")
        self.program("sudo", '"$@"', logged=False)
        self.program("apt-cache", '[[ $2 == linuxcnc-uspace ]] || echo "$2 | 1.0 | somewhere"', logged=False)
        done = self.setup_as(NOBODY)
        self.assertEqual(done.returncode, 1)
        self.assertIn("do not have linuxcnc-uspace; Debian 12 and 13 do", done.stderr)
        self.assertNotIn("install", " ".join(self.calls()))

    def test_failed_update_is_reported(self):
        self.lack("cmake")
        self.program("sudo", '"$@"', logged=False)
        self.program("apt-get", "exit 100")
        done = self.setup_as(NOBODY)
        self.assertEqual(done.returncode, 1)
        self.assertIn("apt-get update failed", done.stderr)

    def test_other_systems_are_reported(self):
        done = self.setup_as(NOBODY)
        self.assertEqual(done.returncode, 1)
        self.assertIn("Debian 12 and 13", done.stderr)


class Configuration(unittest.TestCase):
    """A build folder, configured with real tools."""

    def configure(self, *options):
        self.folder = own_folder(self)
        command = ["cmake", "-S", ROOT, "-B", self.folder, "-G", "Ninja", "-DBUILD_PRODUCT=OFF", *options]
        return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)

    def ninja(self, *words):
        return subprocess.run(["ninja", "-C", self.folder, *words], capture_output=True, text=True, timeout=120, check=False)

    def test_without_the_product_its_packages_are_not_looked_for_and_it_cannot_be_built(self):
        done = self.configure("-DBUILD_TESTING=OFF")
        self.assertEqual(done.returncode, 0, done.stderr)
        with open(os.path.join(self.folder, "CMakeCache.txt"), encoding="utf-8") as file:
            cache = file.read()
        for name in ("TOML_LIBRARY", "MSGFMT"):
            self.assertNotIn(name, cache)
        self.assertEqual(self.ninja("-n", "simulation_mill").returncode, 0)
        for target in ("product", "all"):
            self.assertIn("whole_product", self.ninja("-t", "query", target).stdout)
        refused = self.ninja("whole_product")
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("Run scripts/setup", refused.stdout)

    def test_tests_without_the_product_are_refused(self):
        done = self.configure("-DBUILD_TESTING=ON")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("set BUILD_PRODUCT", done.stderr)


if __name__ == "__main__":
    unittest.main()
