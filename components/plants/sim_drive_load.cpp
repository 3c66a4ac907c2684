// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/first_order_lag.hpp"
#include "components/math/blocks/slew_limit.hpp"
#include "components/math/blocks/usable.hpp"
#include "components/plants/drawn.hpp"
#include "components/plants/sample_and_hold.hpp"
#include "pages/sim_drive_load.page.hpp"

#include <algorithm>
#include <cmath>

namespace plumb {

struct SimDriveLoad final : hal::Component {
    static constexpr hal::About about{"sim_drive_load", "simulated spindle drive: the load that it reports",
                                      page};

    static constexpr hal::Role role = hal::Role::plant;
    using Component::Component;

    hal::In<std::int32_t> seed{this, "seed", 0, "Number of the machine; 0 is the typical one."};
    hal::In<double> cutting_power{this, "cutting-power", 0, "W", "Power of the cut with a sharp tool."};
    hal::In<double> spindle_speed_cmd{this, "spindle-speed-cmd", 0, "rpm", "Commanded speed of the spindle."};
    hal::In<std::int32_t> tool_number{this, "tool-number", 0, "Tool in the spindle; a change orients it."};
    hal::In<std::int32_t> teeth{this, "teeth", 4, "Teeth of the tool."};
    hal::In<double> tool_wear{this, "tool-wear", 0, "1", "Wear of the tool, 0 to 1."};
    hal::In<std::int32_t> cycle{this, "cycle", 0, "Number of the part; a change draws a new part gain."};
    hal::In<bool> coolant{this, "coolant", false, "Coolant is on."};

    Drawn rated_power{this, "rated-power", 3700, 2200, 5500, "W", "Rating of the motor"};
    Drawn idle{this, "idle", 4, 3, 6, "%", "Load of the slowly turning spindle"};
    Drawn idle_speed{this, "idle-speed", 6, 4, 10, "%", "Load of idling at 10000 rpm"};
    Drawn warm_decline{
        this, "warm-decline", 0.2, 0.1, 0.3, "1", "Part of the idle load that a warm spindle loses"};
    Drawn warm_tau{this, "warm-tau", 900, 600, 1200, "s", "Time constant of that loss"};
    Drawn pulse{this, "pulse", 100, 60, 150, "%", "Load while the spindle changes its speed"};
    Drawn pulse_time{this, "pulse-time", 1, 0.2, 2, "s", "Time that it takes from rest to 10000 rpm"};
    Drawn coolant_load{this, "coolant-load", 1, 0.5, 2, "%", "Load of the coolant"};
    Drawn part_spread{this, "part-spread", 0.2, 0.1, 0.2, "1", "Largest deviation of the part gain from 1"};
    Drawn wear_rise{
        this, "wear-rise", 0.3, 0.2, 0.3, "1", "Load that a worn-out tool adds to its cut, as a part of it"};
    Drawn tooth_ripple{
        this, "tooth-ripple", 0.2, 0.1, 0.3, "1", "Amplitude at the tooth frequency, part of the cut"};
    Drawn runout_ripple{this, "runout-ripple", 0.1, 0.05, 0.2, "1", "Amplitude once a turn, part of the cut"};
    Drawn lag{this, "lag", 0.02, 0.005, 0.1, "s", "Time constant of the drive's filter"};
    Drawn sample_time{
        this, "sample-time", 0.002, 0.001, 0.016, "s", "Time between two values; 0 for every period"};
    Drawn white_noise{
        this, "white-noise", 0.3, 0.1, 0.7, "%", "Standard deviation of the white noise in load"};
    Drawn flicker_noise{
        this, "flicker-noise", 0.1, 0.05, 0.5, "%", "Standard deviation of the 1/f noise in load"};
    Drawn quantum{this, "quantum", 0.1, 0.1, 1, "%", "Step in which load is given"};

    hal::Out<double> load{this, "load", "%", "Load that the drive reports."};
    hal::Out<double> truth_load{this, "truth-load", "%", "Load before lag, noise and sampling."};
    hal::Out<double> truth_speed{this, "truth-speed", "rpm", "Speed of the spindle."};
    hal::Function run{this, "update", &SimDriveLoad::update, hal::Place::load};

    void update(double dt) noexcept {
        if (seed_ != seed || !started_) start(seed);
        if (part_ != cycle) gain_ = 1 + part_spread(seed_) * random_.uniform(-1, 1);
        if (tool_ != tool_number) orienting_ = orient_time;
        part_ = cycle;
        tool_ = tool_number;

        const double spindle = idle_load(dt) + (coolant ? coolant_load(seed_) : 0);
        const double all = spindle + cutting_load(dt);
        const double lagged = lag_.step(all, lag(seed_), dt);

        load = drive_.step(lagged, sample_time(seed_), dt, [this](double sample, double since) noexcept {
            const double noise = white_noise(seed_) * random_.gaussian() +
                                 flicker_noise(seed_) * flicker_.step(random_, since);
            const double step = quantum(seed_);
            return step > 1e-9 ? std::round((sample + noise) / step) * step : sample + noise;
        });
        truth_load = all;
        truth_speed = speed_.value();
    }

private:
    static constexpr double top_speed = 10000;  // rpm
    static constexpr double orient_time = 0.2;  // s

    void start(std::int32_t number) noexcept {
        started_ = true;
        seed_ = number;
        random_ = Random(static_cast<std::uint32_t>(number), 'd');
        flicker_ = FlickerNoise(random_);
        drive_ = SampleAndHold(sample_time(number) * random_.uniform());
    }

    // The spindle without a cut: bearings, and the power for a change of its speed.
    double idle_load(double dt) noexcept {
        command_ = usable(spindle_speed_cmd, 1e5, command_);
        const double before = speed_.value();
        const double n = speed_.step(command_, top_speed / std::max(pulse_time(seed_), 1e-3), dt);
        const double turning = std::abs(n) / top_speed;
        const double warm = warm_.step(turning > 0, warm_tau(seed_), dt);
        orienting_ = std::max(0.0, orienting_ - dt);
        const double bearings = turning > 0
                                    ? (idle(seed_) + idle_speed(seed_) * turning * std::sqrt(turning)) *
                                          (1 - warm_decline(seed_) * warm)
                                    : 0;
        return bearings + (n != before || orienting_ > 0 ? pulse(seed_) : 0);
    }

    double cutting_load(double dt) noexcept {
        power_ = usable(cutting_power, 1e6, power_);
        wear_ = usable(tool_wear, 1, wear_);
        const double turns = speed_.value() / 60 * dt;
        const double before = angle_;
        angle_ = std::fmod(angle_ + turns, 1);
        if (power_ == 0) return 0;
        const double ripple = 1 + tooth_ripple(seed_) * tooth_.mean(teeth, before, turns) +
                              runout_ripple(seed_) * runout_.mean(1, before, turns);
        return 100 * power_ / std::max(rated_power(seed_), 1.0) * gain_ * (1 + wear_rise(seed_) * wear_) *
               ripple;
    }

    // A cosine of `waves` waves a turn.
    class Ripple {
    public:
        // Over the turns that follow `angle`.
        double mean(int waves, double angle, double turns) noexcept {
            constexpr double circle = 6.283185307179586;
            if (const double half = circle / 2 * waves * turns; half != half_) {
                half_ = half;
                share_ = std::abs(half) > 1e-6 ? std::sin(half) / half : 1;
            }
            return share_ * std::cos(circle * waves * (angle + turns / 2));
        }

    private:
        double half_ = 0, share_ = 1;  // of the amplitude, which is kept because the sine costs most
    };

    Random random_;
    FlickerNoise flicker_{random_};
    SampleAndHold drive_;
    SlewLimit speed_;
    FirstOrderLag warm_, lag_;
    Ripple tooth_, runout_;
    double command_ = 0, power_ = 0, wear_ = 0;  // last good inputs
    double gain_ = 1, orienting_ = 0, angle_ = 0;
    bool started_ = false;
    std::int32_t seed_ = 0, part_ = 0, tool_ = 0;
};

hal::Model hal::model() {
    return model_of<SimDriveLoad>();
}

}  // namespace plumb
