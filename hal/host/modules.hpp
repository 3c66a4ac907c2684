// SPDX-License-Identifier: GPL-2.0-or-later
// Realtime modules: finds, loads, instantiates and unloads them as LinuxCNC's rtapi_app does, and reports
// errors in rtapi_app's words, which integrators and LinuxCNC's own tests know.
#pragma once

#include <list>
#include <string>
#include <vector>

#include "hal/host/models.hpp"

namespace plumb::host {

class Modules {
public:
    // Modules are looked for in these folders, in this order. The last one must be LinuxCNC's: hal_lib
    // comes from there. `options`: MODULE.NAME=VALUE, each in the place of the NAME that a load of MODULE
    // gives. A module of which the file `models` has a model (Models) is not loaded: the model is.
    explicit Modules(std::vector<std::string> folders, std::vector<std::string> options = {},
                     const std::string& models = "");

    ~Modules();  // unloads everything
    Modules(const Modules&) = delete;

    // Loads a module; `parameters` are NAME=VALUE. Returns 0, or a negative number after a message; when
    // nothing else is loaded, hal_lib is not either then.
    int load(const std::string& name, const std::vector<std::string>& parameters);

    // Unloads a module, and with the last one hal_lib: the next load begins with a new HAL. Returns 0, or a
    // negative number after a message.
    int unload(const std::string& name);

    // Unloads everything, the latest first.
    void unload_all();

    // Creates an instance of a loaded component. Returns the result of its constructor, negative after an
    // error.
    int new_instance(const std::string& component, const std::string& name, const std::string& argument);

    // Loads hal_lib unless it is loaded. This waits for the first need, since hal_lib takes one of
    // LinuxCNC's component numbers. Returns whether it is there; if not, a message has given the reason.
    bool need_hal_library();

    bool hal_library_loaded() const { return !modules_.empty(); }  // it is the first

    Models& models() { return models_; }

    const std::vector<std::string>& folders() const { return folders_; }

    // Rises with every load, unload and new instance: names found before may mean something else since.
    unsigned long changes() const { return changes_; }

private:
    struct Module {
        std::string name;
        void* handle;                  // null: a model
        std::list<std::string> texts;  // of its parameters, which point into them
    };

    Module* find(const std::string& name);
    std::string file_of(const std::string& name) const;
    void unload(Module module);
    // Tells the user how to run without a driver that does not load here.
    void name_models(const std::string& name) const;
    void end_without_modules();
    int load_file(const std::string& name, const std::vector<std::string>& parameters);
    std::vector<std::string> with_options(const std::string& name, std::vector<std::string> parameters) const;

    std::vector<std::string> folders_;
    std::vector<std::string> options_;
    Models models_;
    std::vector<Module> modules_;  // in the order of loading
    unsigned long changes_ = 0;
};

}  // namespace plumb::host
