// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/compensation/centre_height/height_gauge.hpp"
#include "components/compensation/centre_height/height_orders.hpp"
#include "components/compensation/centre_height/height_outputs.hpp"
#include "components/compensation/centre_height/height_procedure.hpp"
#include "components/compensation/centre_height/height_settings.hpp"
#include "components/compensation/centre_height/height_status.hpp"
#include "hal/component.hpp"
#include "pages/centre_height.page.hpp"

#include <string>

namespace plumb {

struct CentreHeight final : hal::Component {
    static constexpr hal::About about{"centre_height",
                                      "measures the height of a lathe tool's edge from turned diameters",
                                      page, "Centre height"};

    static constexpr hal::Role role = hal::Role::compensation;
    using Component::Component;

    hal::LengthUnit unit{this};

    hal::Option<std::string> interlock{this, "interlock", "yes", hal::Permission::about, {"no"}};
    hal::Permission permission{this, interlock, "Y may be moved; else the value is only shown."};
    HeightOrders orders{this};
    hal::Row<hal::In<double>, HeightSettings::posts> x_position{this, "x-position", 0, "mu",
                                                                "Position of X, as a radius."};
    hal::Row<hal::In<double>, HeightSettings::posts> y_position{this, "y-position", 0, "mu",
                                                                "Position of Y."};
    hal::Row<hal::In<double>, HeightSettings::posts> x_zero{
        this, "x-zero", 0, "mu", "Position of X that the program calls 0, tool offset included."};
    hal::In<double> spindle_load{this, "spindle-load", 0, "%", "Load of the spindle of the work."};
    HeightGauge gauge{this};
    KeyedCuts keyed_cuts{this};
    HeightSettings settings{this};

    hal::Out<bool> cut_taken{this, "cut-taken",
                             "The position of the cut was taken or refused, while cut-done is true."};
    hal::Out<bool> value_taken{this, "value-taken",
                               "The last diameter was taken, while value-ready is true."};
    HeightOutputs outputs{this};
    hal::Status<HeightStatus> status{this, permission};
    hal::Function run{this, "update", &CentreHeight::update, hal::Place::measurement};

    void update(double) noexcept {
        permission.step();
        HeightSettings::Values now = settings.values(orders.program_post, orders.program_method);
        now.automatic = permission.enabled();
        const HeightOrders::Given given = orders.read();

        const double load = spindle_load;
        if (load > load_) load_ = load;
        if (given.start) {
            procedure_.begin(now, y_position[now.post], x_zero[now.post]);
            load_ = 0;
        }
        if (given.abort)
            procedure_.interrupt();
        else if (given.stored)
            procedure_.end();
        else if (given.resume)
            procedure_.go_on(now);
        else if (given.cut)
            take_position(now);
        else if (given.entry && given.corrected > 0)
            taken_ = procedure_.correct(now, entered(given), given.corrected);
        else if (given.entry && given.corrected < 0)
            taken_ = procedure_.take_back(-given.corrected);
        else if ((given.value || given.entry) && procedure_.state() == State::measure)
            take_diameter(now, given);
        else if (given.compute && keyed_cuts.keyed)
            procedure_.compute(now, keyed_cuts.read(now, gauge.kind == 1));
        else if (given.compute)
            procedure_.compute(now, keyed_cuts.travel);
        cut_taken_ &= given.cut_done;
        taken_ &= given.value_ready || given.entered;

        outputs.show(procedure_, now);
        status = status_of(
            {procedure_.state(), procedure_.fault(), procedure_.verdict().verdict, status.of_interlock()});
        permission.report({});
        cut_taken = cut_taken_;
        value_taken = taken_;
    }

private:
    void take_position(const HeightSettings::Values& now) noexcept {
        cut_taken_ = procedure_.take_position(now, x_position[now.post], y_position[now.post], load_) ||
                     procedure_.fault() == Detail::no_load;
        load_ = 0;
    }

    void take_diameter(const HeightSettings::Values& now, const HeightOrders::Given& given) noexcept {
        HeightProcedure::Entry entry = entered(given);
        if (!given.entry) {
            const HeightGauge::Reading reading = gauge.read();
            entry.diameter = reading.diameter;
            entry.by_beam = reading.by_beam;
        }
        procedure_.take_diameter(now, entry);
        taken_ = true;
    }

    HeightProcedure::Entry entered(const HeightOrders::Given& given) noexcept {
        HeightProcedure::Entry entry;
        entry.diameter = gauge.as_diameter(orders.entered_diameter);
        entry.wanted = given.cuts >= 1 ? given.cuts : keyed_cuts.count;
        entry.travel = keyed_cuts.travel;
        return entry;
    }

    HeightProcedure procedure_;
    double load_ = 0;  // the largest since the last cut
    bool cut_taken_ = false, taken_ = false;
};

hal::Model hal::model() {
    return model_of<CentreHeight>();
}

}  // namespace plumb
