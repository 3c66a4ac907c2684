// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/thermal_growth/growth_inputs.hpp"
#include "components/compensation/thermal_growth/growth_report.hpp"
#include "components/compensation/thermal_growth/growth_status.hpp"
#include "pages/thermal_growth.page.hpp"

#include <string>

namespace plumb {

using namespace growth_test;

struct ThermalGrowthTest final : hal::Component {
    static constexpr hal::About about{
        "thermal_growth_test",
        "measures how much a machine grows as it warms, and whether its compensation helps", page,
        "Growth test"};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};
    hal::Option<std::string> interlock{this, "interlock", "yes", hal::Permission::about, {"no"}};
    hal::Permission permission{this, interlock};
    Program program{this};
    Machine machine{this};
    Temperatures temperatures{this};
    StopSettings stop_settings{this};

    TestReport report{this};
    hal::Status<Status> status{this, permission};
    hal::Records rows{this};
    GrowthRow row{this};

    hal::Function run{this, "update", &ThermalGrowthTest::update, hal::Place::measurement};

    void prepare() override {
        test_.reserve();
        test_.clear();
    }

    void update(double dt) noexcept {
        permission.step();
        Signals now = program.read(dt);
        machine.read(now.at);
        now.oriented = machine.oriented(now.turned);
        temperatures.read(now.warmth);
        GrowthTest::Settings wanted = stop_settings.read();
        const bool good_settings = wanted.valid();
        if (good_settings) settings_ = wanted;
        settings_.stop.sensors = now.warmth.decides;

        if (program.acknowledges()) test_.acknowledge();
        const GrowthTest::Result result = test_.step(now, settings_, dt);
        walk();

        report.show(test_, settings_);
        if (result == GrowthTest::Result::touch) report.show_touch(now.at);
        if (result == GrowthTest::Result::bore) report.show_bore(test_.bore());
        report.show_states(program.wants_compensation(), program.wants_cooling(), now.confirmed);
        const Fault its_fault = hal::first<Fault>({{test_.fault() != Fault::none, test_.fault()},
                                                   {!now.at.good, Fault::position},
                                                   {!now.warmth.good, Fault::sensor},
                                                   {!good_settings, Fault::settings},
                                                   {program.unconfirmed(), Fault::unconfirmed},
                                                   {!now.warmth.artifact_good, Fault::artifact_temperature}});
        report.fault = its_fault;
        status = status_of({report.now(), test_.stop(), program.runs(), its_fault != Fault::none,
                            program.is_gone(), program.is_paused(), program.is_resumable(),
                            status.of_interlock()});
        permission.report({});
    }

private:
    void walk() noexcept {
        if (rows.wants_forget() && !test_.active()) test_.clear();
        if (rows.wants_restore()) rows.restored(test_.restore(row.given(), settings_));
        rows.show(static_cast<std::int32_t>(test_.records().size()),
                  [&](std::int32_t i) noexcept { row.show(test_.records()[static_cast<std::size_t>(i)]); });
    }

    GrowthTest test_;
    GrowthTest::Settings settings_;  // last good values
};

hal::Model hal::model() {
    return model_of<ThermalGrowthTest>();
}

}  // namespace plumb
