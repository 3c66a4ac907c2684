// SPDX-License-Identifier: GPL-2.0-or-later
#include "hal/host/models.hpp"

#include <dlfcn.h>
#include <hal.h>
#include <rtapi.h>
#include <sys/mount.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <list>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "hal/any_value.hpp"
#include "hal/host/names.hpp"

namespace plumb::host {

namespace {

using Json = nlohmann::json;

const std::map<std::string, hal_type_t> types{
    {"bit", HAL_BIT}, {"float", HAL_FLOAT}, {"s32", HAL_S32}, {"u32", HAL_U32}};
const std::map<std::string, hal_pin_dir_t> directions{{"IN", HAL_IN}, {"OUT", HAL_OUT}, {"IO", HAL_IO}};

// A function of hal_lib, which the host loads while it runs.
#define PLUMB_HAL(name) reinterpret_cast<decltype(&(name))>(dlsym(RTLD_DEFAULT, #name))

}  // namespace

// A pin of the model, or a value of another component.
struct Place {
    hal_type_t type = HAL_FLOAT;
    hal_data_u** pin = nullptr;              // in HAL's memory, where a net changes it
    std::optional<hal::AnyValue> cell = {};  // of another component
    bool writes = false;                     // a pin of a program that has a model

    std::optional<hal::AnyValue> value() const {
        return pin != nullptr ? std::optional(hal::AnyValue(type, *pin)) : cell;
    }
};

class Part;

// A pin or a number of a part. What the user's files do not give has its default, and a write to it is lost.
class Role {
public:
    Role(Part* part, std::string name, double otherwise = 0);
    Role(const Role&) = delete;
    Role& operator=(const Role& other) {
        *this = static_cast<double>(other);
        return *this;
    }

    const std::string name;
    double number;
    const Place* place = nullptr;

    bool given() const { return place != nullptr; }
    bool known() const { return place != nullptr && place->value().has_value(); }
    operator double() const {
        const auto value = place != nullptr ? place->value() : std::nullopt;
        return value ? value->number() : number;
    }
    bool on() const { return static_cast<double>(*this) != 0; }
    void operator=(double value) const {
        if (place == nullptr || !std::isfinite(value) || (place->pin == nullptr && !place->writes)) return;
        const auto found = place->value();
        if (!found) return;
        const hal::AnyValue& pin = *found;
        if (pin.type() == hal::AnyValue::Type::s32)
            value = std::clamp(std::floor(value), -2147483648.0, 2147483647.0);
        if (pin.type() == hal::AnyValue::Type::u32) value = std::clamp(std::floor(value), 0.0, 4294967295.0);
        pin.set_number(value);
    }
};

class Part {
public:
    Part() = default;
    virtual ~Part() = default;
    Part(const Part&) = delete;
    virtual void move(double dt) = 0;
    // A role that is not there yet: the next of a list.
    virtual Role* more(const std::string&) { return nullptr; }

    std::vector<Role*> roles;
};

Role::Role(Part* part, std::string its_name, double otherwise)
    : name(std::move(its_name)), number(otherwise) {
    part->roles.push_back(this);
}

namespace {

constexpr Nanoseconds program_period = 1'000'000;

// The largest value that a limit of 0 allows.
double limit(double value) {
    return value > 0 ? value : 1e300;
}

// Steps to a position, or with a velocity.
struct Stepgen final : Part {
    Role enable{this, "enable", 1}, velocity_mode{this, "velocity-mode"};
    Role command{this, "command"}, velocity_command{this, "velocity-command"};
    Role maxvel{this, "maxvel"}, maxaccel{this, "maxaccel"}, scale{this, "scale", 1};
    Role position{this, "position"}, velocity{this, "velocity"}, counts{this, "counts"},
        rawcounts{this, "rawcounts"};
    double at = 0, speed = 0, target = 0;
    bool first = true;

    void move(double dt) override {
        const double most = limit(maxvel), step = limit(maxaccel) * dt;
        double wanted = velocity_command;
        if (!velocity_mode.on()) {
            // With the target, and faster by as much as it can still lose on the rest of the way.
            const double with_target = first ? 0 : (command - target) / dt,
                         rest = command - at - with_target * dt;
            const double more = std::sqrt(step * step / 4 + 2 * step / dt * std::abs(rest)) - step / 2;
            wanted = with_target + std::copysign(std::min(more, std::abs(rest) / dt), rest);
            target = command;
            first = false;
        }
        speed = std::clamp(std::clamp(wanted, -most, most), speed - step, speed + step);
        if (!enable.on()) speed = 0;
        at += speed * dt;
        position = at;
        velocity = speed;
        counts = at * scale;
        rawcounts = at * scale;
    }
};

// An encoder on a joint or a spindle that does what `source` says. With `ramp` the source is a speed, reached
// at this rate. With `gain` it is the output to a drive, which turns `gain` times as fast, up to `most`. At
// an index the count begins again at 0; the command of a joint comes after it, by as much.
struct Encoder final : Part {
    Role source{this, "source"}, ramp{this, "ramp"}, scale{this, "scale", 1}, pitch{this, "pitch", 1};
    Role gain{this, "gain"}, most{this, "most", 1e300}, enable{this, "enable", 1};
    Role position{this, "position"}, velocity{this, "velocity"}, rpm{this, "rpm"};
    Role counts{this, "counts"}, rawcounts{this, "rawcounts"}, index_enable{this, "index-enable"};
    double last = 0, zero = 0, speed = 0, turned = 0;
    std::optional<double> indexed;
    bool first = true;

    void move(double dt) override {
        if (!source.known()) return;
        double at = source;
        if (ramp > 0) {
            speed = std::clamp(at, speed - ramp * dt, speed + ramp * dt);
            at = turned += speed * dt;
        } else if (gain > 0) {
            at = turned += enable.on() ? std::clamp(at * gain, -most, +most) * dt : 0;
        } else if (first) {
            last = at;
        } else if (indexed && std::abs(at - last + *indexed) < std::abs(*indexed) / 2) {
            zero = 0, last = at, indexed.reset();
        }
        first = false;
        if (index_enable.on() && std::floor(at / pitch) != std::floor(last / pitch)) {
            indexed = at - zero;
            zero = at;
            index_enable = 0;
        }
        const double rate = (at - last) / dt;
        last = at;
        position = at - zero;
        velocity = rate;
        rpm = rate * 60;
        counts = (at - zero) * scale;
        rawcounts = at * scale;
    }
};

// True once the speed of a spindle, reached at `ramp`, is within 2 % of the source.
struct AtSpeed final : Part {
    Role source{this, "source"}, ramp{this, "ramp", 1e300}, out{this, "out"};
    double speed = 0;

    void move(double dt) override {
        const double wanted = source;
        speed = std::clamp(wanted, speed - ramp * dt, speed + ramp * dt);
        out = std::abs(speed - wanted) <= 0.02 * std::abs(wanted) ? 1 : 0;
    }
};

// A switch on axes: true while the true position of one, `source-N` + `start-N`, is at or beyond `place-N` in
// `direction-N`.
struct Switch final : Part {
    struct Axis {
        Axis(Part* part, const std::string& number)
            : source(part, "source-" + number),
              start(part, "start-" + number),
              place(part, "place-" + number),
              direction(part, "direction-" + number, 1) {}
        Role source, start, place, direction;
    };
    Role out{this, "out"}, inverted{this, "inverted"};
    std::list<Axis> axes;

    Role* more(const std::string& name) override {
        const std::string number = std::to_string(axes.size());
        if (name.size() < number.size() ||
            name.compare(name.size() - number.size(), number.size(), number) != 0)
            return nullptr;
        axes.emplace_back(this, number);
        const auto its =
            std::find_if(roles.begin(), roles.end(), [&](const Role* role) { return role->name == name; });
        return its == roles.end() ? nullptr : *its;
    }
    void move(double) override {
        bool on = false;
        for (const Axis& axis : axes)
            if (axis.source.known()) on = on || (axis.source + axis.start - axis.place) * axis.direction >= 0;
        out = on != inverted.on() ? 1 : 0;
    }
};

// The inverse of a bit.
struct Inverse final : Part {
    Role in{this, "in"}, out{this, "out"};
    void move(double) override { out = in.on() ? 0 : 1; }
};

// Gives its input on.
struct Follow final : Part {
    Role in{this, "in"}, factor{this, "factor", 1}, out{this, "out"};
    void move(double) override { out = in * factor; }
};

// The measured speed of a spindle, in the unit of its input, as far as the source is reached at `ramp`.
struct Speed final : Part {
    Role in{this, "in"}, source{this, "source"}, ramp{this, "ramp", 1e300}, factor{this, "factor", 1};
    Role out{this, "out"};
    double speed = 0, unit = 0;

    void move(double dt) override {
        const double wanted = source;
        speed = std::clamp(wanted, speed - ramp * dt, speed + ramp * dt);
        if (wanted != 0) unit = in / wanted;
        out = speed * unit * factor;
    }
};

// A drive's states by CiA 402: the status that belongs to each order of the control word, one state in a
// period.
struct Drive final : Part {
    Role control{this, "control"}, target{this, "target"}, target_velocity{this, "target-velocity"},
        mode{this, "mode"};
    Role status{this, "status"}, position{this, "position"}, velocity{this, "velocity"};
    Role mode_display{this, "mode-display"};
    static constexpr int disabled = 0x40, ready = 0x21, switched_on = 0x23, operates = 0x27, remote = 0x200;
    int state = disabled;

    void move(double) override {
        const int order = static_cast<int>(control) & 0x0f;
        const bool shutdown = (order & 0x07) == 0x06, on = order == 0x07, enable = order == 0x0f;
        if (!shutdown && !on && !enable)
            state = disabled;
        else if (state == disabled || shutdown)
            state = shutdown ? ready : disabled;
        else
            state = state == ready ? switched_on : enable ? operates : switched_on;
        status = state | remote;
        mode_display = mode;
        if (state == operates) position = target;
        velocity = state == operates ? static_cast<double>(target_velocity) : 0;
    }
};

// The component cia402: brings a drive into operation, and scales its positions. A drive that is told to home
// counts from where it stands.
struct Cia402 final : Part {
    Role status{this, "status"}, enable{this, "enable"}, command{this, "command"}, actual{this, "actual"};
    Role scale{this, "scale", 1}, control{this, "control"}, mode{this, "mode"}, target{this, "target"};
    Role position{this, "position"}, enabled{this, "enabled"}, home{this, "home"};
    double zero = 0;

    void move(double) override {
        constexpr int cyclic_synchronous_position = 8;
        const int state = static_cast<int>(status) & 0x6f;
        const bool operates = state == Drive::operates;
        const bool goes_on = state == Drive::switched_on || operates;
        const double counts = scale.on() ? static_cast<double>(scale) : 1;
        control = !enable.on() ? 0x06 : state == Drive::ready ? 0x07 : goes_on ? 0x0f : 0x06;
        enabled = operates ? 1 : 0;
        mode = cyclic_synchronous_position;
        const bool homes = operates && home.on();
        if (homes) zero = actual;
        home = 0;
        position = (actual - zero) / counts;
        target = operates && !homes ? command * counts + zero : static_cast<double>(actual);
    }
};

template <class Kind>
std::unique_ptr<Part> made() {
    return std::make_unique<Kind>();
}

using Maker = std::unique_ptr<Part> (*)();
const std::map<std::string, Maker> kinds{
    {"stepgen", made<Stepgen>}, {"encoder", made<Encoder>}, {"at-speed", made<AtSpeed>},
    {"switch", made<Switch>},   {"inverse", made<Inverse>}, {"speed", made<Speed>},
    {"follow", made<Follow>},   {"drive", made<Drive>},     {"cia402", made<Cia402>}};

}  // namespace

struct Models::Description {
    struct Pin {
        std::string name;
        hal_type_t type;
        hal_pin_dir_t direction;
        double value;
    };
    struct Part {
        Maker maker;
        std::map<std::string, std::string> pins;
        std::map<std::string, double> numbers;
    };
    std::vector<Pin> pins;
    std::vector<std::string> functions;
    std::vector<Part> parts;

    explicit Description(const Json& json) : functions(json.at("functions").get<std::vector<std::string>>()) {
        for (const Json& pin : json.at("pins"))
            pins.push_back({pin.at(0).get<std::string>(), types.at(pin.at(1).get<std::string>()),
                            directions.at(pin.at(2).get<std::string>()), pin.at(3).get<double>()});
        for (const Json& part : json.at("parts"))
            parts.push_back({kinds.at(part.at("kind").get<std::string>()),
                             part.at("pins").get<std::map<std::string, std::string>>(),
                             part.value("numbers", std::map<std::string, double>())});
    }
};

struct Models::Model {
    int component = -1;
    std::map<std::string, Place> places;  // addresses stay
    std::vector<std::unique_ptr<Part>> parts;

    // The parts of a description, at the places of this model.
    void add(const Description& described);
    void move(double dt) const {
        for (const auto& part : parts) part->move(dt);
    }
    static void update(void* model, long period) {
        static_cast<Model*>(model)->move(static_cast<double>(period) * 1e-9);
    }
    static void nothing(void*, long) {}
};

void Models::Model::add(const Description& described) {
    for (const Description::Part& part : described.parts) {
        auto& made = parts.emplace_back(part.maker());
        const auto role_of = [&](const std::string& name) {
            const auto found = std::find_if(made->roles.begin(), made->roles.end(),
                                            [&](const Role* role) { return role->name == name; });
            return found != made->roles.end() ? *found : made->more(name);
        };
        for (const auto& [name, pin] : part.pins)
            if (Role* const role = role_of(name)) role->place = &places[pin];
        for (const auto& [name, number] : part.numbers)
            if (Role* const role = role_of(name)) role->number = number;
    }
}

Models::Models(const std::string& file) : given_(!file.empty()) {
    if (file.empty()) return;
    try {
        std::ifstream text(file);
        const Json json = Json::parse(text);
        for (const auto& [module, described] : json.at("modules").items())
            described_[module] = std::make_unique<Description>(described);
        if (json.contains("program_pins")) {
            programs_model_ = std::make_unique<Model>();
            const Description described(json.at("program_pins"));
            for (const Description::Pin& pin : described.pins)
                programs_model_->places[pin.name].writes = pin.direction != HAL_IN;
            programs_model_->add(described);
        }
        programs_ = json.value("programs", programs_);
        path_ = json.value("path", path_);
        module_folder_ = json.value("module_folder", module_folder_);
    } catch (const std::exception& error) {
        throw std::runtime_error("the models in " + file + " cannot be read: " + error.what());
    }
}

Models::~Models() = default;

void Models::cover_programs() const {
    for (const auto& [file, path] : programs_)
        if (mount(file.c_str(), path.c_str(), nullptr, MS_BIND, nullptr) != 0)
            throw std::runtime_error("the model of " + path + ": " + std::strerror(errno));
    const char* const present = std::getenv("PATH");
    if (!path_.empty()) setenv("PATH", ((present != nullptr ? present : "") + (":" + path_)).c_str(), 1);
}

int Models::load(const std::string& module) {
    const Description& described = *described_.at(module);
    auto model = std::make_unique<Model>();
    model->component = PLUMB_HAL(hal_init)(module.c_str());
    if (model->component < 0) return model->component;
    const auto failed = [&](int result) {
        rtapi_print_msg(RTAPI_MSG_ERR, "%s: its model cannot be made\n", module.c_str());
        PLUMB_HAL(hal_exit)(model->component);
        return result < 0 ? result : -ENOMEM;
    };
    for (const Description::Pin& pin : described.pins) {
        Place& place = model->places[pin.name];
        place.type = pin.type;
        place.pin = static_cast<hal_data_u**>(PLUMB_HAL(hal_malloc)(sizeof(void*)));
        if (place.pin == nullptr) return failed(-ENOMEM);
        const int result = PLUMB_HAL(hal_pin_new)(pin.name.c_str(), pin.type, pin.direction,
                                                  reinterpret_cast<void**>(place.pin), model->component);
        if (result != 0) return failed(result);
        hal::AnyValue(pin.type, *place.pin).set_number(pin.value);
    }
    model->add(described);
    const auto reads = [](const std::string& name) {
        return name.find("read") != std::string::npos || name.find("update") != std::string::npos;
    };
    auto mover = std::find_if(described.functions.begin(), described.functions.end(), reads);
    if (mover == described.functions.end()) mover = described.functions.begin();
    for (auto name = described.functions.begin(); name != described.functions.end(); ++name) {
        const int result = hal_export_funct(name->c_str(), name == mover ? Model::update : Model::nothing,
                                            model.get(), 0, 0, model->component);
        if (result != 0) return failed(result);
    }
    PLUMB_HAL(hal_ready)(model->component);
    loaded_[module] = std::move(model);
    return 0;
}

void Models::unload(const std::string& module) {
    PLUMB_HAL(hal_exit)(loaded_.at(module)->component);
    loaded_.erase(module);
}

void Models::move(Nanoseconds now) {
    if (!programs_model_ || now - moved_ < program_period) return;
    programs_model_->move(static_cast<double>(now - moved_) * 1e-9);
    moved_ = now;
}

bool Models::watches() const {
    if (programs_model_ && PLUMB_HAL(hal_init) != nullptr && !programs_model_->parts.empty()) return true;
    return std::any_of(loaded_.begin(), loaded_.end(), [](const auto& loaded) {
        const auto& places = loaded.second->places;
        return std::any_of(places.begin(), places.end(),
                           [](const auto& place) { return place.second.pin == nullptr; });
    });
}

void Models::resolve(const Names& names) {
    const auto find = [&](Model& model) {
        for (auto& [name, place] : model.places) {
            if (place.pin != nullptr) continue;
            const std::optional<Cell> cell = names.find(name);
            place.cell = cell ? std::optional(cell->value) : std::nullopt;
        }
    };
    for (const auto& [module, model] : loaded_) find(*model);
    if (programs_model_) find(*programs_model_);
}

void Models::lose_names() {
    if (programs_model_)
        for (auto& [name, place] : programs_model_->places) place.cell.reset();
}

}  // namespace plumb::host
