# SPDX-License-Identifier: GPL-2.0-or-later
"""The modules and programs that parts and functions load, beside the machine's own."""

ONCE = ("growth-log", "interlock", "linuxcnc-alive", "linuxcnc-link", "plumb-retain")  # a machine has one of each


class Modules:
    """The instances of each module, and the components that programs make.

    functions   those whose own modules are among them
    """

    def __init__(self, functions, parts, machine):
        self.functions, self.machine = functions, machine
        self.instances = {}
        for modules in [part.modules for part in parts] + [function.modules for function in functions]:
            for module, instances in modules.items():
                self.instances.setdefault(module, []).extend(instances)
        self.programs = [name for part in parts for name in part.programs]

    def has(self, pin):
        names = [name for names in self.instances.values() for name in names] + self.programs
        return any(pin.startswith(name + ".") for name in names)

    def shared(self):
        """Module and instances for each loadrt line of stages.hal, without modules of functions and of the user."""
        own = {module for function in self.functions for module in function.modules}
        return [
            (module, instances)
            for module, instances in self.instances.items()
            if module not in own and not self.machine.loads(module)
        ]

    def _names_in_use(self):
        """(instance, its module, the owner of this name) of each name that the user has too."""
        wanted = [(instance, module) for module, instances in self.instances.items() for instance in instances]
        for instance, module in wanted + [(program, program) for program in self.programs]:
            owner = self.machine.complete.owner_of_prefix(instance)
            if owner:
                yield instance, module, owner

    def presence_problems(self):
        """A sentence for each component that the user has wired by hand, if a machine may have only one."""
        own = {module for function in self.functions for module in function.modules}
        names = " and ".join(function.name for function in self.functions)
        sentence = "Your configuration loads %s%s, and plumb wire loads it for %s. A machine has one: leave yours out."
        for instance, module, owner in self._names_in_use():
            if owner == module and (module in ONCE or module in own):
                yield sentence % (instance, self.machine.at(instance), names)

    def name_problems(self):
        """A sentence for each name that the user has given to something else."""
        sentence = "The name %s is in use: by %s in your configuration%s, and by %s here. Rename yours."
        for instance, module, owner in self._names_in_use():
            if owner != module:
                yield sentence % (instance, owner, self.machine.at(instance), module)

    def load_problems(self):
        """A sentence for each module that the user loads without the instances that are wanted."""
        state = self.machine.halfiles
        for module, instances in self.instances.items():
            lacking = [instance for instance in instances if state.owner_of_prefix(instance) != module]
            if self.machine.loads(module) and lacking:
                names = ",".join([*state.instances(module), *lacking])
                sentence = "Your configuration loads %s%s, and a module is loaded once: write names=%s in your line, or use TWOPASS."
                yield sentence % (module, self.machine.at(module), names)


def is_once(pin):
    """Whether the pin belongs to a component that a machine has only once."""
    return pin.split(".")[0] in ONCE
