// SPDX-License-Identifier: GPL-2.0-or-later
// The correction of squareness: from the position of the axes and the tool to offsets of X, Y and Z.
//
//     ErrorTables       the tables of the axes, read by another thread; take_over() puts new ones in force
//     SquarenessModel   set() takes settings, set_tool() the tool; at() gives the offsets at a position
//     CorrectionRamps   the ramps of the offsets after a change of settings or tool
//
// The chain of axes with its tilts and tables gives the place of the tip (kinematic_chain.hpp). TipCorrection
// moves X, Y and Z until the tip is where it would be on a perfect machine.
#pragma once

#include "components/compensation/squareness/squareness_settings.hpp"
#include "components/io/files/error_table_file.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/ramped_correction.hpp"
#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/error_table.hpp"
#include "components/math/geometry/kinematic_chain.hpp"
#include "components/math/geometry/tip_correction.hpp"
#include "hal/option.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plumb {

// The error tables of a machine's axes. Another thread reads them again while a realtime function uses
// them: one set is in use; the other one is free for reading until the function takes it over.
class ErrorTables {
public:
    using Set = std::array<std::optional<DirectedErrorTable>, 7>;  // by coordinate()

    // At load, `paths` separated by colons. Throws with file, line and reason.
    void load(const std::string& paths, const AxisChain& chain) {
        chain_ = chain;
        paths_ = paths;
        const bool any = !paths.empty() && paths != "none";  // an INI file has no empty values
        for (std::size_t begin = 0; any && begin <= paths.size();) {
            const std::size_t end = std::min(paths.find(':', begin), paths.size());
            const std::string path = paths.substr(begin, end - begin);
            if (path.empty()) throw std::invalid_argument("table=" + paths + ": a path is empty");
            files_.emplace_back(hal::absolute_path("table", path));
            begin = end + 1;
        }
        sets_[0] = read();
    }

    bool any() const noexcept { return !files_.empty(); }

    // The number of axes with a table.
    std::int32_t count() const noexcept {
        return static_cast<std::int32_t>(
            std::count_if(in_use().begin(), in_use().end(), [](const auto& its) { return its.has_value(); }));
    }

    // Realtime: asks for the tables to be read again, after a reading that is under way.
    void ask() noexcept { wanted_ = true; }

    // Realtime, each period: whether the tables in use are others than in the period before.
    bool take_over() noexcept {
        const std::int32_t done = done_.load(std::memory_order_acquire);
        if (done != taken_) {
            taken_ = done;
            refused_ = !good_;
            if (good_) in_use_ = 1 - in_use_;
            return good_;  // later, it may ask again: this period still needs the tables before
        }
        if (wanted_ && asked_.load(std::memory_order_relaxed) == taken_) {
            wanted_ = false;
            asked_.store(taken_ + 1, std::memory_order_release);
        }
        return false;
    }

    const Set& in_use() const noexcept { return sets_[in_use_]; }
    const Set& before() const noexcept { return sets_[1 - in_use_]; }  // in the period of a take-over
    bool refused() const noexcept { return refused_; }                 // at the last reading

    // Another thread: reads if it was asked to. Returns the reason if it takes nothing over, else "".
    // Throws std::bad_alloc if there is no memory for the reason either; the next call reads then.
    std::string work() {
        const std::int32_t asked = asked_.load(std::memory_order_acquire);
        if (asked == done_.load(std::memory_order_relaxed)) return "";
        std::string reason;
        good_ = false;
        try {
            sets_[1 - in_use_] = read();
            good_ = true;
        } catch (const std::exception& error) {
            reason = error.what();
        }
        done_.store(asked, std::memory_order_release);
        return reason;
    }

    // Machine, date and the like, from the files that were read since the last call, and once each file that
    // has no seal. For the reading thread.
    std::vector<std::string> take_facts() { return std::exchange(facts_, {}); }

private:
    Set read() {
        Set result;
        ErrorTableFiles read = read_error_tables(files_);
        for (auto& [letter, table] : read.tables) {
            const auto axis = static_cast<Axis>(error_table_file::axes.find(letter));
            if (!chain_.has(axis))
                throw std::runtime_error("table=" + paths_ + ": there is one of " + letter +
                                         ", an axis that the chain does not have");
            result[static_cast<std::size_t>(coordinate(axis))] = std::move(table);
        }
        for (const error_table_file::Facts& file : read.files) {
            facts_.push_back(file.sentence());
            if (!file.seal.empty())
                unsealed_.erase(file.file);
            else if (unsealed_.insert(file.file).second)
                facts_.push_back(file.advice());
        }
        return result;
    }

    AxisChain chain_;
    std::string paths_;
    std::vector<std::filesystem::path> files_;
    std::vector<std::string> facts_;
    std::set<std::string> unsealed_;  // which the facts have named
    std::array<Set, 2> sets_;
    std::size_t in_use_ = 0;  // written in realtime, while nothing is being read
    bool good_ = false;       // the last reading; handed over by done_
    std::atomic<std::int32_t> asked_{0}, done_{0};
    std::int32_t taken_ = 0;
    bool wanted_ = false, refused_ = false;
};

// The correction that a position wants with one set of settings, one tool and one set of tables.
class SquarenessModel {
public:
    struct Motion {
        AxisPosition position = AxisPosition::Zero(), velocity = AxisPosition::Zero();  // mu, mu/s
        Eigen::Vector3d angles = Eigen::Vector3d::Zero();                               // deg, of A, B and C
        Eigen::Vector3d rates = Eigen::Vector3d::Zero();                                // deg/s
    };
    // Of each axis: its direction of motion d, -1 to 1, and its change.
    struct Directions {
        AxisPosition values = AxisPosition::Zero(), rates = AxisPosition::Zero();  // 1, 1/s
    };
    struct Result {
        RampedCorrection::Wanted wanted;
        RampedCorrectionOf<1>::Wanted wanted_parallel;     // of U, V or W
        Eigen::Vector3d error = Eigen::Vector3d::Zero();   // mu, tip error without correction
        bool beyond_table = false, beyond_rotary = false;  // a table, one of A, B or C, does not reach here
        Eigen::Matrix4d by_direction = Eigen::Matrix4d::Zero();  // mu, dc/dd of X, Y, Z and U, V or W
        AxisPosition reversal = AxisPosition::Zero();            // mu, part of the wanted offsets by d
        bool steady = true;     // false: it changes with the position as on no machine, and is invalid
        bool singular = false;  // the errors are steady, and the pose of the rotary axes enlarges them
    };

    // `millimetres` in a machine unit; tables are in millimetres.
    SquarenessModel(const AxisChain& axes, double millimetres) noexcept
        : axes_(axes),
          parallel_(axes.parallel_axis()),
          millimetres_(millimetres),
          correction_(KinematicChain::Settings{axes, {}, {}, {}, {}}) {}

    const Eigen::Vector3d& tool() const noexcept { return tool_; }
    bool active() const noexcept { return active_; }

    // Of the path in X, Y and Z, with the axis parallel to one of them; mu/s.
    Eigen::Vector3d velocity(const Motion& motion) const noexcept {
        return correction_.chain().ideal_slopes() * motion.velocity;
    }

    // Axes whose scale LinuxCNC compensates: their tables of it do not count. `learned`: axes whose dead
    // points chopping corrects: their scale does not differ by direction.
    void leave_out(const std::array<bool, 4>& scales, const std::array<bool, 4>& learned) noexcept {
        left_out_ = scales;
        learned_ = learned;
    }

    void set_tool(const Eigen::Vector3d& tool) noexcept { tool_ = tool; }

    // The tool in mu, from the gauge point to the tip. The correction is 0 if not active.
    void set(const SquarenessSettings::Values& settings, const Eigen::Vector3d& tool, bool active) noexcept {
        tool_ = tool;
        active_ = active;
        most_ = settings.max_correction;
        shares_ = settings.parallel_axis_corrects && parallel_;
        KinematicChain::Settings s;
        s.axes = axes_;
        s.reading = settings.reading();
        s.datum = settings.datum();
        for_each_axis([&](Axis axis, std::size_t i) {
            s.tilts[i] = {settings.angles(axis), settings.of(axis).tool_follows};
            pivot_[static_cast<Eigen::Index>(i)] = settings.of(axis).pivot;
        });
        for_each_rotary([&](Axis axis) {
            RotaryPlace& its = s.places[static_cast<std::size_t>(direction(axis))];
            its = settings.place(axis);
            if (axes_.work.has(axis)) its.angles[direction(axis)] *= -1;  // as its angle
        });
        correction_ = TipCorrection(s, -settings.reference_tool_offset);
        displaces_ = correction_.chain().has_rotary() || !displacement().isZero(1e-9);
    }

    // Whether the tilts displace the tip of a tool along Z. One that turns all axes and the work alike does
    // not. With a rotary axis this is taken for granted.
    bool displaces() const noexcept { return displaces_; }

    // Call it each period: it begins at the last result, and so needs few steps.
    Result at(const Motion& motion, const Directions& d, const ErrorTables::Set& tables) noexcept {
        Result result;
        const AxisPosition q = motion.position - pivot_;
        for_each_rotary([&](Axis axis) {
            correction_.chain().set_angle(axis, motion.angles[direction(axis)]);
            result.beyond_rotary |= take_error(axis, motion.angles[direction(axis)], tables);
        });
        TipCorrection::Correction c;
        for (int step = 0; step < 3; ++step) {
            result.beyond_table = take_errors(TipCorrection::corrected(q, led_to_, share_.offset), d, tables);
            const TipCorrection::Share last = share_;
            share_ = shares_ ? correction_.share(*parallel_, q, last.offset) : TipCorrection::Share{};
            c = correction_.at(q, tool_, led_to_, share_);
            const bool steady_share = std::abs(share_.slope) <= 0.5;
            result.steady = steady_share && steady(c.slopes, c.by_rotary);
            if (!result.steady) {
                result.singular = steady_share && correction_.chain().has_rotary() &&
                                  steady(c.error_slopes, c.error_by_rotary);
                led_to_.setZero();
                share_ = {};
                return result;
            }
            if (correction_.chain().linear()) break;
            const double way = (c.offset - led_to_).norm() + std::abs(share_.offset - last.offset);
            led_to_ = c.offset;
            if (way * millimetres_ < near) break;
        }
        result.beyond_table |= result.beyond_rotary;
        result.error = c.error;
        result.wanted.most = most_;
        result.wanted_parallel.most = most_;
        if (active_) {
            result.wanted.offset = c.offset;
            result.wanted.velocity = c.slopes * motion.velocity;
            if (correction_.chain().has_rotary()) result.wanted.velocity += c.by_rotary * motion.rates;
            result.wanted_parallel.offset[0] = share_.offset;
            result.wanted_parallel.velocity[0] = share_.slope * motion.velocity[3];
        }
        if (correction_.chain().directed()) take_direction(c, d, result);
        return result;
    }

private:
    // mm; where errors of the axes bend by 0.002 per mm, 1e-9 of it remains.
    static constexpr double near = 1e-3;

    // Whether a correction, or an error, changes with the position as on a machine.
    bool steady(const PositionSlopes& slopes, const RotarySlopes& by_rotary) const noexcept {
        return slopes.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= 0.5 &&
               by_rotary.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() * millimetres_ <= 0.5;
    }

    // By the tilts alone, with a tool along Z, at a place where no two displacements cancel.
    Eigen::Vector3d displacement() noexcept {
        return correction_
            .at(AxisPosition(997, -613, 457, 389), Eigen::Vector3d(0, 0, 149), Eigen::Vector3d::Zero(), {})
            .error;
    }

    void take_direction(const TipCorrection::Correction& c, const Directions& d,
                        Result& result) const noexcept {
        result.by_direction.topRows<3>() = c.by_direction;
        result.by_direction(3, 3) = share_.by_direction;
        if (!active_) return;
        const AxisPosition rates = result.by_direction * d.rates, part = result.by_direction * d.values;
        result.wanted.velocity += rates.head<3>();
        result.wanted_parallel.velocity[0] += rates[3];
        for (Eigen::Index i = 0; i < 4; ++i) {
            const double offset = i < 3 ? result.wanted.offset[i] : result.wanted_parallel.offset[0];
            result.reversal[i] = bounded(offset, most_) - bounded(offset - part[i], most_);
        }
    }

    // Reads the errors of the axes from the tables. Returns whether a table does not reach `there`.
    bool take_errors(const AxisPosition& there, const Directions& d,
                     const ErrorTables::Set& tables) noexcept {
        bool beyond = false;
        for_each_axis([&](Axis axis, std::size_t i) {
            if (!tables[i]) return;
            const auto k = static_cast<Eigen::Index>(i);
            const double place = (there[k] + pivot_[k]) * millimetres_;
            DirectedErrorTable::Reading reading = tables[i]->at(place, d.values[k]);
            const auto own = static_cast<std::size_t>(direction(axis));
            if (left_out_[i] || learned_[i]) {
                const ErrorTable::Reading mean = left_out_[i] ? ErrorTable::Reading{} : tables[i]->at(place);
                reading.at.errors[own] = mean.errors[own];
                reading.at.slopes[own] = mean.slopes[own];
                reading.halves[own] = 0;
            }
            correction_.chain().set_error(axis, error(there[k], reading));
            beyond |= !tables[i]->covers(place);
        });
        return beyond;
    }

    // Of a rotary axis. Returns whether its table does not reach the angle.
    bool take_error(Axis axis, double angle, const ErrorTables::Set& tables) noexcept {
        const auto& table = tables[static_cast<std::size_t>(coordinate(axis))];
        if (!table) return false;
        AxisError its = error(angle, {table->at(angle)});
        its.slope.translation /= millimetres_;  // per deg, not per mu
        its.slope.angles /= millimetres_;
        correction_.chain().set_error(axis, its);
        return !table->covers(angle);
    }

    template <typename Function>
    void for_each_axis(const Function& call) const noexcept {
        for (const AxisBranch* branch : {&axes_.work, &axes_.tool})
            for (const Axis axis : *branch) call(axis, static_cast<std::size_t>(coordinate(axis)));
    }

    template <typename Function>
    void for_each_rotary(const Function& call) const noexcept {
        if (!correction_.chain().has_rotary()) return;
        for (const AxisBranch* branch : {&axes_.work, &axes_.tool})
            for (const Axis axis : branch->members)
                if (rotary(axis)) call(axis);
    }

    AxisError error(double position, const DirectedErrorTable::Reading& reading) const noexcept {
        AxisError result;
        result.position = position;
        for (int i = 0; i < 3; ++i) {
            const auto translation = static_cast<std::size_t>(i), angle = translation + 3;
            result.value.translation[i] = reading.at.errors[translation] / millimetres_;
            result.slope.translation[i] = reading.at.slopes[translation];
            result.half.translation[i] = reading.halves[translation] / millimetres_;
            result.value.angles[i] = reading.at.errors[angle];
            result.slope.angles[i] = reading.at.slopes[angle] * millimetres_;
            result.half.angles[i] = reading.halves[angle];
        }
        return result;
    }

    AxisChain axes_;
    std::optional<Axis> parallel_;  // U, V or W
    double millimetres_;
    AxisPosition pivot_ = AxisPosition::Zero();
    TipCorrection correction_;
    Eigen::Vector3d tool_ = Eigen::Vector3d::Zero();  // mu
    bool active_ = false, displaces_ = false;
    std::array<bool, 4> left_out_{}, learned_{};
    double most_ = 0;                                   // mu
    bool shares_ = false;                               // U, V or W corrects its own travel
    Eigen::Vector3d led_to_ = Eigen::Vector3d::Zero();  // mu, the last correction
    TipCorrection::Share share_{};                      // of U, V or W, the last
};

// The corrections of X, Y and Z, as a vector, and of U, V or W: each on its way to the wanted correction.
struct CorrectionRamps {
    RampedCorrection xyz;
    RampedCorrectionOf<1> parallel;

    // `before` is the result at this position with the former settings.
    void step(const SquarenessModel::Result& now, const SquarenessModel::Result& before, double max_rate,
              double dt) noexcept {
        xyz.step(now.wanted, before.wanted, max_rate, dt);
        parallel.step(now.wanted_parallel, before.wanted_parallel, max_rate, dt);
    }
    bool ramping() const noexcept { return xyz.ramping() || parallel.ramping(); }
    bool limited() const noexcept { return xyz.limited() || parallel.limited(); }
};

}  // namespace plumb
