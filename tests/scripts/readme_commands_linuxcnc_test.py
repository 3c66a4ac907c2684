# SPDX-License-Identifier: GPL-2.0-or-later
"""Each command in a code block of a README or of CONTRIBUTING.md is run here, is run by a test, or has a reason why not."""

import collections
import glob
import os
import re
import shutil
import subprocess
import unittest

import linuxcnc_runs
import pages
import starts
from tree import BUILD, ROOT, own_folder

PATIENCE = 100  # s for a command that takes a few

# Why no test runs a command.
LONG = "It takes longer than 30 s."
ROOT_NEEDED = "It needs root."
NETWORK = "It needs the network."
STOCK = "It takes longer than 30 s: stock LinuxCNC runs at its own pace."
REASONS = (LONG, ROOT_NEEDED, NETWORK, STOCK)

# A command that a test runs: its file, and words of it.
Tested = collections.namedtuple("Tested", "path words")

# A command that starts an INI file which a test starts.
Started = collections.namedtuple("Started", "ini")

# A command of another page, which has its entry.
Other = collections.namedtuple("Other", "page")

# A command that runs here: in this folder (of the configuration; "." is the clone), after a line of the shell, with a change of
# its text, and with a line that succeeds if it had its effect.
Run = collections.namedtuple("Run", "folder before change then", defaults=("", "", None, ""))

COPY = Run("empty")
EXPORT = Run(then="command -v plumb && /usr/bin/python3 -c 'import plumb'")
MILL_PAGE = Tested("tests/configs/mill_config_test.py", "test_commissioning_is_as_on_the_page")
REPORT = Tested("tests/commissioning/plumb_growth_test.py", 'growth("report", self.log')
PLAN = Tested("tests/commissioning/plumb_growth_test.py", 'growth("plan", "--hours"')
IDENTIFY = Tested("tests/commissioning/plumb_growth_test.py", 'growth("identify", self.log')
LEANS = Tested("tests/configs/portal_linuxcnc_test.py", 'r"^    plumb (squareness .*)$"')
OWN_HAL = Tested("tests/scripts/readme_test.py", "(plumb bench limit.hal")


def bench(name):
    """A bench whose smallest run is in a test of its own."""
    paths = glob.glob(os.path.join(ROOT, "tests", "scripts", "*_test.py"))
    words = 'run_bench("%s"' % name
    return Tested(next((os.path.relpath(path, ROOT) for path in paths if words in read(path)), "tests/scripts"), words)


def chosen(name):
    """A file in Python that `scripts/test -R` chooses."""
    paths = glob.glob(os.path.join(ROOT, "tests", "**", name + "_test.py"), recursive=True)
    return Tested(os.path.relpath(paths[0], ROOT) if paths else "tests", "unittest.TestCase")


def read(path):
    with open(path, encoding="utf-8") as file:
        return file.read()


def readings(axis):
    """A line of the shell that writes the readings on squareness's page into the file of an axis."""
    rows = re.findall(r"(?m)^    (position,.*|[\d.]+,[\d.,]+)$", read(os.path.join(ROOT, "components/compensation/squareness/README.md")))
    return "printf '%%s\\n' %s > %s_readings.csv" % (" ".join(rows), axis)


def printed(page, begin):
    """A line of the shell that finds, in the file out, the line of a page that begins so; line ends count as blanks."""
    line = next(line.strip() for line in read(os.path.join(ROOT, page)).splitlines() if line.strip().startswith(begin))
    return "tr -s ' \\n' ' ' < out | grep -qF -- '%s'" % line


HERE = Run(".")

# By page: a command, or the beginning of one and "...".
COMMANDS = {
    "README.md": {
        "scripts/bench mill": bench("mill"),
        "scripts/test": LONG,
        "sudo scripts/package bookworm": ROOT_NEEDED,
        "sudo apt install ./build-bookworm/plumb_*.deb": ROOT_NEEDED,
        "plumb wire squareness --ini my.ini --apply": Tested("tests/commands/plumb_wire_apply_linuxcnc_test.py", "--apply"),
        "plumb wire --ini my.ini --undo": Tested("tests/commands/plumb_wire_apply_linuxcnc_test.py", "--undo"),
        "sudo apt remove plumb": ROOT_NEEDED,
        "plumb commission squareness": Tested("tests/programs/commission_scenario.py", '"commission", "squareness", "--who"'),
        "plumb bench limit.hal ...": OWN_HAL,
    },
    "CONTRIBUTING.md": {
        "scripts/test": LONG,
        "scripts/test-on trixie": ROOT_NEEDED,
        "scripts/package --twice trixie": ROOT_NEEDED,
        "scripts/try-package trixie": ROOT_NEEDED,
        "git clone --depth 1 https://github.com/LinuxCNC/linuxcnc build-trixie/linuxcnc-sources": NETWORK,
        "scripts/linuxcnc-package build-trixie/linuxcnc-sources trixie": ROOT_NEEDED,
        "scripts/package --linuxcnc build-trixie/linuxcnc-2.10 trixie": ROOT_NEEDED,
        "scripts/package --arch arm64 trixie": ROOT_NEEDED,
        "scripts/try-arm64 trixie": ROOT_NEEDED,
        "scripts/try-package --linuxcnc build-trixie/linuxcnc-2.10 trixie": ROOT_NEEDED,
        "scripts/test-on --linuxcnc build-trixie/linuxcnc-2.10 trixie": ROOT_NEEDED,
        "scripts/setup speed_benchmark && build/tests/speed_benchmark": LONG,
        "scripts/sensor-speed": LONG,
        "scripts/test-arm64": LONG,
        "scripts/linuxcnc-tests": NETWORK,
        "scripts/wire-samples": LONG,
        "scripts/bench-configs FOLDER": Tested("tests/scripts/bench_configs_script_test.py", "bench_configs.py"),
        "scripts/campaign faults --for 2h": LONG,
        "cmake -S . -B build-thread ...": LONG,
        "cmake --build build-thread ...": LONG,
        "cmake -S . -B build-unsigned ...": LONG,
        "cmake --build build-unsigned ...": LONG,
        "new() ...": Run("."),
        "new components/plants/sim_drive_load.cpp": Run(".", before="new()", then="grep -q SimFeedDrive components/plants/sim_feed_drive.cpp"),
        "new components/plants/sim_drive_load.page": Run(".", before="new()", then="grep -q 'sim_feed_drive turns' components/plants/sim_feed_drive.page"),
        "new tests/...": Run(".", before="new()", then="grep -q SimFeedDrive tests/components/plants/sim_feed_drive_test.cpp"),
        "scripts/test -R ...": LONG,
    },
    "components/commissioning/commission/README.md": {
        "python3 tests/support/run.py ...": LONG,
        "scripts/campaign commission --seed 2": LONG,
    },
    "components/commissioning/squareness/README.md": {
        "plumb squareness --json --chain w-X-Y.b-Z-C-t > machine.json": Run("empty", then="grep -q can_correct machine.json"),
        "plumb squareness --json --input machine.json": Run("empty", before="plumb squareness --json --chain w-X-Y.b-Z-C-t > machine.json"),
        "plumb squareness --chain w-Z.b-X-Y-C-t ...": Run("empty", then="test -s column.svg"),
    },
    "components/commissioning/volume/README.md": {
        "plumb volume uncertainty ...": Run("empty", change=("--json", "--json > volume.json"), then="grep -q at_least volume.json"),
    },
    "components/io/sensor/README.md": {
        "scripts/sensor-speed": LONG,
        "scripts/campaign sensors --count 12 --fresh": LONG,
        "scripts/bench mill --load-every 0.1": Run(".", change=("--load-every", "--for 6min --output mill --load-every")),
    },
    "components/screens/README.md": {
        "plumb panel": Tested("tests/components/screens/panel_window_test.py", '"plumb-panel"'),
        "scripts/panel-pictures FOLDER": LONG,
        "scripts/panel-stories": LONG,
        "python3 scripts/panel_texts.py build": Run("."),
    },
    # The tables of claims: the benches of a page take at most 4 s.
    "components/compensation/centre_height/README.md": {
        "build/bin/plumb bench ...": HERE,
        "scripts/test --long -R lathe_panel_linuxcnc": chosen("lathe_panel_linuxcnc"),
        "scripts/test -R lathe_linuxcnc": chosen("lathe_linuxcnc"),
        "scripts/test -R lathe_twin_linuxcnc": chosen("lathe_twin_linuxcnc"),
        "scripts/test -R centre_height_test": Tested("tests/components/compensation/centre_height_test.cpp", "(CentreHeight, LaserBeamsGiveDiameters)"),
    },
    "components/compensation/chopping/README.md": {
        "build/bin/plumb bench ...": HERE,
        "scripts/test -R grinder_linuxcnc": chosen("grinder_linuxcnc"),
        "scripts/test -R chopping_test": Tested("tests/components/compensation/chopping_test.cpp", "ShiftsItsRegionByCommandAndWhenAnAxisCrossesEitherWay)"),
    },
    "components/compensation/squareness/NOT_SQUARE.md": {
        "plumb squareness --chain w.b-Y-X-Z-t ...": Run("empty", change=("u=0.2mm", "u=0.2mm > out"), then=printed("components/compensation/squareness/NOT_SQUARE.md", "Add ")),
        "plumb squareness --chain w.b-X-Y-Z-t ...": Run("empty", change=("u=0.2mm", "u=0.2mm > out"), then=printed("components/compensation/squareness/NOT_SQUARE.md", "setp square.ec0y ")),
    },
    "components/compensation/squareness/README.md": {
        "build/bin/plumb bench ...": HERE,
        "build/bin/plumb squareness ...": HERE,
        "scripts/test -R portal_linuxcnc": chosen("portal_linuxcnc"),
        "plumb squareness --chain w-X-Y.b-Z-C-t --square ...": Run("empty"),
        "plumb volume reversal x_readings.csv ...": Run("empty", before=readings("x"), then="grep -q X, x.csv"),
        "plumb volume reversal y_readings.csv ...": Run("empty", before=readings("y"), then="grep -q Y, y.csv"),
        "plumb squareness --table x.csv --ini my.ini": Run("empty", before=readings("x") + """
plumb volume reversal x_readings.csv --axis X --output x.csv
printf '[JOINT_0]\\nBACKLASH = 0\\n' > my.ini"""),
    },
    "components/compensation/thermal_displacement/README.md": {
        "build/bin/plumb bench ...": HERE,
        "scripts/test -R mill_linuxcnc": chosen("mill_linuxcnc"),
        "scripts/test -R mill_config": chosen("mill_config"),
    },
    "components/compensation/thermal_growth/README.md": {
        "build/bin/plumb bench ...": HERE,
        "build/bin/plumb run --speed 10 -- linuxcnc configs/growth/growth.ini": LONG,
        "scripts/test -R growth_linuxcnc": chosen("growth_linuxcnc"),
        "build/bin/plumb growth report configs/growth/logs/growth-*.csv": REPORT,
        "scripts/bench growth_faults": Other("scripts/benches/README.md"),
        "build/bin/plumb growth identify configs/growth/logs/growth-*.csv": IDENTIFY,
        "scripts/bench axis_growth": Other("scripts/benches/README.md"),
    },
    "configs/grinder/README.md": {
        "plumb example ...": COPY,
        "plumb run --speed 10 -- linuxcnc grinder.ini": Run(),
        "plumb run --speed 10 -- linuxcnc face.ini": Run(),
        "plumb bench bench.hal ...": Run(then="test -s grinder.csv"),
    },
    "configs/growth/README.md": {
        "plumb example ...": Run("empty", then="test -f growth.ini"),
        "plumb run --speed 10 -- linuxcnc growth.ini": LONG,
        "plumb growth report logs/growth-*.csv": REPORT,
        "plumb growth identify ...": IDENTIFY,
        "plumb growth plan --hours 4": PLAN,
        "plumb growth plan --hours 4 --log logs/growth-*.csv --ngc > growth_plan.ngc": PLAN,
        "linuxcnc axis.ini": LONG,
        "mv logs first": Run(before="mkdir logs"),
        "plumb run --speed 10 -- linuxcnc identified.ini": LONG,
    },
    "configs/lathe/README.md": {
        "plumb example ...": COPY,
        "export ...": EXPORT,
        "plumb run --speed 10 -- linuxcnc -r twin.ini": Started("lathe/twin.ini"),
        "plumb run --speed 10 -- linuxcnc -r twin.ini stations.ngc": Tested("tests/configs/lathe_twin_linuxcnc_test.py", '["stations"]'),
        "plumb run --speed 10 -- linuxcnc -r lathe.ini": Run(then="grep -q '^T1 .* Y-0' tool.tbl"),
        "plumb run --speed 10 -- linuxcnc -r two.ini": Run(then="grep -Eq '^T1 .* Y[+]0[.]0(29|30)' tool.tbl"),
        "plumb bench bench.hal ...": Run(then="test -s lathe.csv"),
        "plumb run -- linuxcnc axis.ini": Started("lathe/axis.ini"),
        "halcmd setp ...": Tested("tests/programs/lathe_scenario.py", "self.lines_of_readme("),
        "plumb bench configs/lathe/by_hand.hal ...": Run(".", then="grep -q '^1,-0.03' height.csv"),
    },
    "configs/mill/README.md": {
        "plumb example ...": COPY,
        "export ...": EXPORT,
        "plumb run --speed 10 -- linuxcnc mill.ini setup.ngc ...": MILL_PAGE,
        "plumb run -- linuxcnc axis.ini": Started("mill/axis.ini"),
        # As the page says, setup.ngc comes first.
        "plumb run --speed 10 -- linuxcnc mill.ini part.ngc ...": Run(change=("mill.ini ", "mill.ini setup.ngc "), then="test -s part.csv"),
        "linuxcnc mill.ini setup.ngc part.ngc": STOCK,
        "plumb run --speed 10 -- linuxcnc mill.ini by_time.py": Tested("tests/programs/mill_scenario.py", "by_time.make_parts"),
        "plumb run --speed 10 -- linuxcnc growth.ini ...": Tested("tests/configs/mill_growth_linuxcnc_test.py", '"setup.ngc", "growth_test/%s.ngc"'),
        "plumb growth report logs/growth-*.csv": REPORT,
        "echo ...": MILL_PAGE,
        "plumb contacts load.txt": MILL_PAGE,
        "plumb contacts load.txt --set ...": MILL_PAGE,
        "plumb bench replay.hal ...": MILL_PAGE,
    },
    "configs/mill/measured_growth.md": {
        "plumb bench configs/mill/bench.hal ...": LONG,
    },
    "configs/portal/README.md": {
        "plumb example ...": COPY,
        "export ...": EXPORT,
        "plumb run --speed 10 -- linuxcnc column.ini ...": Run(),
        "plumb run -- linuxcnc axis_portal.ini": Started("portal/axis_portal.ini"),
        "linuxcnc column.ini ...": STOCK,
        "scripts/bench part --seed 7": bench("part"),
        "plumb squareness ...": LEANS,
    },
    "configs/sensors/README.md": {
        "modbus_sensor --list cabinet.toml": Tested("tests/components/io/modbus_sensor_test.py", '[SENSOR, "--list", file]'),
    },
    "configs/three_axis/README.md": {
        "plumb run --speed 10 -- linuxcnc three_axis.ini": Started("three_axis/three_axis.ini"),
        "plumb run --speed 10 -- linuxcnc three_axis.ini part.ngc ...": Run(before="cp sample.ngc part.ngc", then="test -s part.csv"),
        "linuxcnc -r three_axis.ini": STOCK,
        "plumb run -- linuxcnc axis.ini": Started("three_axis/axis.ini"),
        "plumb example ...": COPY,
    },
    "hal/host/README.md": {
        "build/bin/plumb bench limit.hal ...": OWN_HAL,
        "build/bin/plumb bench configs/mill/bench.hal ...": Run(".", change=("/tmp/", ""), then="test -s mill.csv"),
        "build/bin/plumb run --speed 10 -- linuxcnc ...": Started("three_axis/three_axis.ini"),
        "build/bin/plumb run --speed 20 -- halrun ...": Run("."),
        "plumb run --models --speed 10 -- linuxcnc my.ini": Tested("tests/host/models_linuxcnc_test.py", '"run", "--models"'),
        "plumb bench --ini my.ini --models --for 1min --expect 'finite({joint.0.motor-pos-cmd})'": Tested(
            "tests/commands/plumb_bench_ini_test.py", '"--ini", path, "--models"'
        ),
        "plumb bench my.hal --models --for 1min": Tested("tests/host/models_linuxcnc_test.py", '"it.hal", "--models"'),
    },
    "scripts/benches/README.md": {
        "scripts/bench": Tested("tests/scripts/bench_script_test.py", "test_without_a_name_every_bench_is_listed"),
        "scripts/bench mill --help": Run("."),
        "scripts/bench trust --attacks": LONG,
        "scripts/bench trust --events ...": Tested("tests/scripts/load_events_test.py", "trust.simulate_event("),
        "scripts/bench trust --seeds ...": Run(".", change=("--seeds 40", "--seeds 1 --for 10min --output trust")),
        "scripts/bench rivals": LONG,
        "scripts/bench rivals --days ...": Run(".", change=("--seeds 8 --seed 501 --contacts DIR", "--seeds 1 --contacts rivals"), then="test -s rivals/plant1-12/1.txt"),
        "scripts/bench rivals DIR/*/*.txt": Tested("tests/scripts/rivals_bench_test.py", "replay.table("),
        "scripts/bench mill": bench("mill"),
        "scripts/bench growth": Tested("tests/scripts/growth_bench_test.py", "growth.bench(machines"),
        "scripts/bench growth --curve FILE ...": Tested("tests/scripts/growth_bench_test.py", "growth_curves.read_curve("),
        "scripts/bench growth_faults": LONG,  # with one machine, too: nine faults
        "scripts/bench growth_readme": Tested("tests/scripts/growth_readme_bench_test.py", "growth_readme.run("),
        "scripts/bench mill_growth": LONG,  # with one machine, too: six tests
        "scripts/bench axis_growth": Run(".", change=("axis_growth", "axis_growth --seeds 1 --for 10min")),
        "scripts/bench axis_growth --days ...": Tested("tests/commissioning/plumb_growth_test.py", "growth_days.pair("),
        "scripts/bench axis_growth --contacts ...": LONG,
        "scripts/bench growth_sensors": Run(".", change=("growth_sensors", "growth_sensors --seeds 1 --for 30min")),
        "scripts/bench pairs": bench("pairs"),
        "scripts/bench portal": bench("portal"),
        "scripts/bench circle": bench("circle"),
        "scripts/bench volume": bench("volume"),
        "scripts/bench volume --list ...": Tested("tests/scripts/volume_bench_script_test.py", 'run_bench("volume", "--list"'),
        "scripts/bench grinder": bench("grinder"),
        "scripts/bench ablation ...": Tested("tests/scripts/ablation_bench_script_test.py", "ablation.without("),
        "scripts/bench part": bench("part"),
        "scripts/bench lathe": bench("lathe"),
        "scripts/bench lathe --strangers ...": Tested("tests/scripts/lathe_bench_test.py", "lathe_strangers.simulate_strangers("),
        "scripts/bench panel": Tested("tests/scripts/panel_bench_script_test.py", "panel.bench("),
        "dask-scheduler": Tested("tests/scripts/cluster_test.py", '"dask_scheduler"'),
        "PYTHONPATH=scripts/benches dask-worker ...": Tested("tests/scripts/cluster_test.py", '"dask_worker"'),
        "scripts/bench growth --cluster tcp://mill:8786": Tested("tests/scripts/cluster_test.py", '("--cluster", self.address)'),
    },
}


def fits(key, command):
    return command.startswith(key[:-3].rstrip()) if key.endswith("...") else command == key


def entry_of(page, command):
    """The longest entry that fits a command, or None."""
    return max((key for key in COMMANDS.get(page, {}) if fits(key, command)), key=len, default=None)


class Listed(unittest.TestCase):
    def test_every_command_of_a_page_is_run_by_a_test_or_has_a_reason(self):
        count = 0
        for page in pages.readmes():
            for found in pages.commands(page):
                count += 1
                with self.subTest("%s:%d" % found[:2]):
                    self.assertIsNotNone(entry_of(page, found.text), "%s, line %d: no test runs %r, and COMMANDS has no reason" % found)
        self.assertGreater(count, 80)

    def test_every_entry_is_a_command_of_its_page(self):
        for page, entries in COMMANDS.items():
            used = {entry_of(page, found.text) for found in pages.commands(page)}
            self.assertEqual([key for key in entries if key not in used], [], page + " has these commands no more")

    def test_the_named_tests_run_them(self):
        started = starts.declared()
        for page, entries in COMMANDS.items():
            for key, how in entries.items():
                with self.subTest(page + ": " + key):
                    if isinstance(how, Tested):
                        path = os.path.join(ROOT, how.path)
                        self.assertTrue(os.path.isfile(path) and how.words in read(path), "%s has no %s" % how)
                    elif isinstance(how, Started):
                        self.assertIn(how.ini, started)
                    elif isinstance(how, Other):
                        self.assertIn(key, COMMANDS[how.page])
                        self.assertNotIsInstance(COMMANDS[how.page][key], Other)
                    elif not isinstance(how, Run):
                        self.assertIn(how, REASONS)

    def test_commands_are_found_in_a_page(self):
        page = "Run\n\n    plumb run -- linuxcnc my.ini   # a comment\n    FAR=1 anything\n\n    it printed this\n\n" \
               "```sh\nanything --else\n```\n\n```hal\nloadrt pid\n```\n- a point\n    of two lines\n\n    scripts/new\n\n    nobody --knows it\n"
        self.assertEqual(
            [found[1:] for found in pages.commands("a page", page)],
            [(3, "plumb run -- linuxcnc my.ini"), (4, "FAR=1 anything"), (9, "anything --else"), (18, "scripts/new"), (20, "nobody --knows it")],
        )


class Running(unittest.TestCase):
    """In a copy of the clone, whose components and configurations may be written."""

    @classmethod
    def setUpClass(cls):
        cls.folder = own_folder(cls)
        cls.clone = os.path.join(cls.folder, "clone")
        os.mkdir(cls.clone)
        for name in ("hal", "scripts"):
            os.symlink(os.path.join(ROOT, name), os.path.join(cls.clone, name))
        os.symlink(BUILD, os.path.join(cls.clone, "build"))
        for name in ("components", os.path.join("tests", "components", "plants"), os.path.join("tests", "support")):
            shutil.copytree(os.path.join(ROOT, name), os.path.join(cls.clone, name), symlinks=True)
        os.mkdir(os.path.join(cls.clone, "configs"))
        for path in glob.glob(os.path.join(ROOT, "configs", "*", "*.ini")):
            name = os.path.basename(os.path.dirname(path))
            if not os.path.exists(os.path.join(cls.clone, "configs", name)):
                shutil.copytree(os.path.dirname(path), os.path.join(cls.clone, "configs", name))
        with open(os.path.join(cls.clone, "limit.hal"), "w", encoding="utf-8") as file:
            file.write(re.search(r"```hal\n(.*?)```", pages.read("hal/host/README.md"), re.S)[1])

    def run_as_it_stands(self, found, how):
        configuration = os.path.dirname(found.page)
        folder = os.path.join(self.clone, how.folder or configuration)
        if how.folder == "empty":
            folder = own_folder(self)
        line, then = found.text, how.then
        if how.change:
            self.assertIn(how.change[0], line)
            line = line.replace(*how.change)
        before = how.before
        if before == "new()":
            before = next(each.text for each in pages.commands(found.page) if each.text.startswith("new()"))
        if how is COPY:
            then = "ls %s/*.ini" % os.path.basename(configuration)
        line = re.sub(r"\blinuxcnc (?!-r)", "linuxcnc -r ", line)  # else it shows a window
        line = re.sub(r"^scripts/bench\b", "/usr/bin/python3 scripts/benches", line)  # else it sets up and builds
        variables = linuxcnc_runs.environment(self.folder)
        if line.startswith("export"):
            variables.update(HOME=os.path.join(self.folder, "home"), PATH="/usr/bin:/bin")
            if not os.path.exists(os.path.join(variables["HOME"], "plumb")):
                os.symlink(self.clone, os.path.join(variables["HOME"], "plumb"))
        lines = "\n".join(filter(None, ["set -e", before, line, then]))
        done = subprocess.run(["bash", "-c", lines], cwd=folder, env=variables, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(done.returncode, 0, "%s, line %d: %s\n" % found + done.stdout)

    def test_commands_run_as_the_pages_show_them(self):
        for page in COMMANDS:
            for found in pages.commands(page):
                how = COMMANDS[page].get(entry_of(page, found.text))
                if isinstance(how, Run):
                    with self.subTest("%s:%d" % found[:2]):
                        self.run_as_it_stands(found, how)


if __name__ == "__main__":
    unittest.main()
