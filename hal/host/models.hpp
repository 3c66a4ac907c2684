// SPDX-License-Identifier: GPL-2.0-or-later
// Models of drivers: components of the host with the pins and functions of a driver whose hardware is not
// here. A file in JSON (--models), which hal/models writes from the user's HAL files and the model files,
// says per module:
//
//     pins        [name, type, direction, value at first]
//     functions   the names that HAL files add to threads
//     parts       {"kind": KIND, "pins": {ROLE: NAME}, "numbers": {ROLE: VALUE}}; see the kinds in models.cpp
//
// "program_pins" describes the pins of programs, whose components stand_in.py makes: {"pins", "parts"}.
// "programs" has files that cover programs for the host alone, [file, path], and "path" a folder for PATH.
// "module_folder" has modules that were compiled for this run.
//
// A role of a part names a pin of the module, or any pin or signal of HAL, which is then only read. The parts
// move in the module's first function that reads (".read", ".update"), else in its first function: as with
// the driver, nothing moves in a HAL without this function. Programs move once in a millisecond.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hal/host/time.hpp"

namespace plumb::host {

class Names;

class Models {
public:
    // Without a file there is no model. Throws std::runtime_error with the file's name if it is damaged.
    explicit Models(const std::string& file);
    ~Models();
    Models(const Models&) = delete;

    // Lets the programs of this host find theirs. Only in namespaces of the host's own. Throws
    // std::runtime_error.
    void cover_programs() const;

    bool given() const { return given_; }
    const std::string& module_folder() const { return module_folder_; }
    bool has(const std::string& module) const { return described_.count(module) > 0; }

    // As modules are loaded: 0, or a negative number after a message.
    int load(const std::string& module);
    void unload(const std::string& module);

    // Whether a loaded part reads a pin of another component; and finds these pins again.
    bool watches() const;
    void resolve(const Names& names);
    void lose_names();

    // Moves the pins of programs.
    void move(Nanoseconds now);

private:
    struct Description;
    struct Model;

    bool given_;
    std::vector<std::pair<std::string, std::string>> programs_;
    std::string path_, module_folder_;
    std::map<std::string, std::unique_ptr<Description>> described_;
    std::map<std::string, std::unique_ptr<Model>> loaded_;
    std::unique_ptr<Model> programs_model_;
    Nanoseconds moved_ = 0;
};

}  // namespace plumb::host
