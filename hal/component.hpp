// SPDX-License-Identifier: GPL-2.0-or-later
// A component is an ordinary object whose members declare its pins, functions and options in HAL.
//
//     struct Doubler final : hal::Component {
//         static constexpr hal::About about{"doubler", "twice the input", "The output is twice the input."};
//         static constexpr hal::Role role = hal::Role::compensation;
//         using Component::Component;
//
//         hal::In<double> in{this, "in", 0, "mu", "Value to double."};
//         hal::Out<double> out{this, "out", "mu", "Twice the input."};
//         hal::Function run{this, "update", &Doubler::update, "After the source of in."};
//
//         void update(double) noexcept { out = 2 * in; }
//     };
//
//     hal::Model hal::model() { return model_of<Doubler>(); }
#pragma once

#include "hal/axes.hpp"
#include "hal/codes.hpp"
#include "hal/function.hpp"
#include "hal/group.hpp"
#include "hal/length_unit.hpp"
#include "hal/option.hpp"
#include "hal/permission.hpp"
#include "hal/pin.hpp"
#include "hal/registrar.hpp"
#include "hal/role.hpp"
#include "hal/status_pins.hpp"
#include "hal/told.hpp"

#include <memory>
#include <string>
#include <type_traits>

namespace plumb::hal {

class Component {
public:
    static constexpr Role role = Role::none;  // unless the component declares its own
    static constexpr const char* former_name =
        nullptr;  // of a program that was renamed: a link for one release

    explicit Component(Registrar& registrar) : registrar_(registrar) {}
    Component(const Component&) = delete;
    Component& operator=(const Component&) = delete;
    virtual ~Component() = default;

    // Called once at load, before HAL sees the component as ready. May allocate, read files and throw: the
    // exception's text becomes the reason for which the module is not loaded.
    virtual void prepare() {}

    // Called again and again on a thread of the module, never on a realtime one, and never twice at a time;
    // the virtual-time host calls it between periods. Does the work that update() has requested through an
    // atomic flag, and hands the finished result over by an atomic index. Bounded work, reported by pins.
    // An exception is shown to the operator, and background() is called again.
    virtual void background() {}

    // Asked once, after prepare(): if no instance has work for background(), there is no thread.
    virtual bool has_background() const noexcept { return true; }

    // Called once when a program is asked to end, at once, as other components may be unloaded the next
    // moment; background() may run beside it. LinuxCNC waits 2 s. Never called in a module.
    virtual void finish() {}

private:
    friend Registrar& registrar(Component*);
    Registrar& registrar_;  // valid during construction only
};

inline Registrar& registrar(Component* component) {
    return component->registrar_;
}

// The page is the text of the manual page that the declarations do not give; hal/page.hpp says how it is
// written. NAME.page beside NAME.cpp is embedded as `page` by #include "pages/NAME.page.hpp". The title
// stands above its page in plumb panel and before its messages; without one it is the name of the instance.
struct About {
    const char* name;
    const char* summary;
    const char* page;
    const char* title = "";
};

// A task of a program that needs no HAL, `PROGRAM --NAME FILE`. It may throw; its result is the exit status.
struct WithoutHal {
    const char* name = nullptr;  // null after the last of an array
    const char* sentence = nullptr;
    int (*run)(const std::string& file) = nullptr;
};

// A loadable module: its manual text and a way to build one instance.
struct Model {
    About about;
    std::unique_ptr<Component> (*make)(Registrar&);
    bool has_background;
    const WithoutHal* without_hal = nullptr;  // of a program
    double period = 0.1;  // s between two calls, of a program, unless the user gives another
    Role role = Role::none;
    const char* former_name = nullptr;
};

template <class C>
Model model_of() {
    Model model{C::about, [](Registrar& r) -> std::unique_ptr<Component> { return std::make_unique<C>(r); },
                !std::is_same_v<decltype(&C::background), void (Component::*)()>};
    model.role = C::role;
    model.former_name = C::former_name;
    return model;
}

Model model();  // defined by each component's .cpp, once per module

}  // namespace plumb::hal
