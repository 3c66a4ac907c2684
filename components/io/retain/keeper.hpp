// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/atomic_file.hpp"
#include "components/io/retain/computer.hpp"
#include "components/io/retain/record_walk.hpp"
#include "components/io/retain/retain_settings.hpp"
#include "components/io/retain/retained_file.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <map>
#include <mutex>
#include <new>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace plumb {

// Puts the values of a file in force, all or none of them, and from then on keeps them in that file.
// Threads may call step(), finish() and state() at the same time.
class Keeper {
public:
    // Throws std::runtime_error if the settings are wrong, or another program has the file.
    explicit Keeper(const std::string& toml) : toml_(toml), settings_(RetainSettings::read(toml)) {
        try {
            open();
        } catch (const std::system_error& error) {
            if (error.code() == std::errc::device_or_resource_busy)
                throw std::runtime_error(toml_ + ": " + settings_.store.string() +
                                         " is kept by another plumb-retain");
            open_later(error.what());
        }
    }

    const RetainSettings& settings() const { return settings_; }

    struct State {
        bool restored = false;
        bool waiting = false;
        Fault fault = Fault::none;
        std::int32_t saves = 0;
    };

    // While a step or finish() runs, this waits for its end.
    State state() const {
        const std::lock_guard alone(mutex_);
        return {phase_ == Phase::keeping, phase_ == Phase::waiting,
                fault_ != Fault::none ? fault_ : writing_fault_, saves_};
    }

    enum class Answer { none, accept, renew };

    // What to do with a store that is not taken without a question.
    void answer(Answer given) {
        const std::lock_guard alone(mutex_);
        if (phase_ != Phase::asking || given == Answer::none) return;
        if (given == Answer::renew) stored_ = {};
        origin_.begin();
        fault_ = Fault::none;
        phase_ = Phase::finding;
        due_ = {};
    }

    // The next bit of work, if it is time for it. Throws std::bad_alloc, and does that work in the next
    // step.
    void step() {
        const std::lock_guard alone(mutex_);
        const auto now = Clock::now();
        if (phase_ == Phase::over || now < due_) return;
        try {
            if (phase_ == Phase::opening) open();
            if (phase_ == Phase::finding) find();
            if (phase_ == Phase::waiting) restore();
            if (phase_ == Phase::keeping) keep();
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::system_error& error) {
            if (phase_ == Phase::opening) return open_later(error.what());
            begin_again(error.what());
        } catch (const RecordRefused& error) {
            fail(Fault::refused, toml_ + ": " + error.what());
        } catch (const std::exception& error) {
            begin_again(error.what());
        }
    }

    // The last look, and the last write; later steps have no effect. A component that does not answer keeps
    // the values of the last look.
    void finish() {
        const std::lock_guard alone(mutex_);
        if (phase_ == Phase::over) return;
        try {
            if (phase_ == Phase::keeping) look();
        } catch (const std::exception&) {
        }
        write();
        phase_ = Phase::over;
    }

private:
    using Clock = std::chrono::steady_clock;
    enum class Phase { opening, asking, finding, waiting, keeping, over };
    static constexpr std::chrono::milliseconds between_looks{1000};

    // Throws std::system_error while the store cannot be read.
    void open() {
        try {
            file_.emplace(settings_.store);
            if (const auto text = file_->read()) {
                stored_ = retained_file::parse(*text, settings_.machine, file_->path().string());
                written_ = *text;
                take_over_from_former_names();
            }
            report_left_out();
            fault_ = judge_origin();
            phase_ = fault_ == Fault::none ? Phase::finding : Phase::asking;
        } catch (const retained_file::Refused& error) {
            fail(error.fault, error.what());
        }
    }

    Fault judge_origin() {
        if (!settings_.bound) return Fault::none;
        if (written_.empty()) {
            origin_.begin();
            return Fault::none;
        }
        const Fault found = origin_.judge(stored_.origin);
        if (found != Fault::none) report(file_->path().string() + ": " + sentence(found));
        return found;
    }

    void open_later(const std::string& why) {
        file_.reset();
        fault_ = Fault::inaccessible;
        due_ = Clock::now() + std::chrono::seconds(1);
        report(why);
    }

    // A component that comes back has values of its own, and gets the kept ones.
    void begin_again(const std::string& why) {
        if (is_complete()) stored_ = *image_;
        phase_ = Phase::finding;
        fault_ = Fault::unfit;
        due_ = Clock::now() + std::chrono::seconds(1);
        report(toml_ + ": " + why);
        write();
    }

    // Writes no pin before all pins and components are there and fit.
    void find() {
        const auto pins = hal::list_pins();
        for (const std::string& name : settings_.pins) {
            const hal::NamedPin pin = writable(name);
            if (pins.count(name) && pins.at(name).direction == "OUT") throw Unfit(name + " is an output");
            const auto kept = stored_.pins.find(name);
            if (kept != stored_.pins.end() && !pin.takes(kept->second))
                throw Unfit(name + ", " + pin.type_name() + ", cannot be " +
                            retained_file::value_text(kept->second));
        }
        walks_.clear();
        for (const std::string& component : settings_.records) {
            const RecordWalk& walk = walks_.emplace(component, RecordWalk(component, pins)).first->second;
            const auto kept = stored_.records.find(component);
            if (kept != stored_.records.end()) walk.check(kept->second);
        }
        if (fault_ != Fault::none) {  // components that have just come may yet set their pins
            fault_ = Fault::none;
            due_ = Clock::now() + std::chrono::seconds(1);
            return;
        }
        phase_ = Phase::waiting;
        asked_ = Clock::now();
    }

    // Stays in its phase while realtime does not answer.
    void restore() {
        due_ = Clock::now() + std::chrono::milliseconds(200);
        for (auto& [component, walk] : walks_) {
            if (walk.answers()) continue;
            if (Clock::now() - asked_ > std::chrono::seconds(10))
                report(toml_ + ": " + component +
                       " does not answer: is it in a thread, and do the threads run?");
            return;
        }
        std::map<std::string, hal::Value> former;
        try {
            for (const std::string& name : settings_.pins) {
                const auto kept = stored_.pins.find(name);
                if (kept == stored_.pins.end()) continue;
                const hal::NamedPin pin = writable(name);
                former[name] = pin.read();
                pin.write(kept->second);
            }
            for (auto& [component, walk] : walks_) walk.mark();
            for (auto& [component, walk] : walks_) {
                const auto kept = stored_.records.find(component);
                if (kept != stored_.records.end() && !walk.give(kept->second)) return withdraw(former);
            }
        } catch (const Unfit&) {
            withdraw(former);
            throw;
        }
        if (!is_complete()) image_.reset();  // else the image is the restored values
        phase_ = Phase::keeping;
        due_ = {};
    }

    // Undoes a restore: the pins get their former values, the components have no records.
    void withdraw(const std::map<std::string, hal::Value>& former) {
        for (const auto& [name, value] : former)
            if (const auto pin = hal::NamedPin::find(name)) pin->write(value);
        for (auto& [component, walk] : walks_) {
            try {
                walk.withdraw();
            } catch (const Unfit&) {  // it has gone, and its records with it
            }
        }
    }

    void keep() {
        due_ = Clock::now() + std::min<Clock::duration>(every_, between_looks);
        follow_list();
        look();
        if (Clock::now() >= write_due_) write();
    }

    // A screen adds pins to the list while all works. Only the list is followed, not the other settings.
    void follow_list() {
        try {
            const RetainSettings now = RetainSettings::read(toml_);
            if (now.pins == settings_.pins) return;
            for (const std::string& name : now.pins) writable(name);
            settings_.pins = now.pins;
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& error) {
            report(std::string(error.what()) + ": the list of before stays in force");
        }
    }

    void look() {
        Retained seen = image_.value_or(Retained());
        seen.pins.clear();
        for (const std::string& name : settings_.pins) seen.pins[name] = writable(name).read();
        for (auto& [component, walk] : walks_)
            if (auto records = walk.read()) seen.records[component] = std::move(*records);
        image_ = std::move(seen);
    }

    // Each component has shown its records; an empty list counts.
    bool is_complete() const { return image_ && image_->records.size() == walks_.size(); }

    void write() {
        if (!is_complete()) return;
        try {
            if (text_with(origin_.now()) != written_) {
                if (settings_.bound) origin_.note();
                const std::string text = text_with(origin_.next());
                file_->write(text);
                written_ = text;
                if (settings_.bound) origin_.written();
                ++saves_;
                write_due_ = Clock::now() + every_;
            }
            if (settings_.bound) origin_.note();
            writing_fault_ = Fault::none;
        } catch (const std::system_error& error) {
            writing_fault_ = Fault::inaccessible;
            report(error.what());
        }
    }

    std::string text_with(const retained_file::Origin& origin) const {
        return retained_file::compose(*image_, settings_.machine, settings_.bound ? &origin : nullptr);
    }

    static hal::NamedPin writable(const std::string& name) {
        const auto pin = hal::NamedPin::find(name);
        if (!pin) throw Unfit("there is no pin " + name);
        if (pin->linked()) throw Unfit(name + " is linked, and plumb-retain has to write it");
        return *pin;
    }

    // The values of an instance under its former name, unless there are some under its own name too.
    void take_over_from_former_names() {
        for (const auto& [instance, former] : settings_.formerly) {
            for (const std::string& name : settings_.pins)
                if (name.rfind(instance + '.', 0) == 0)
                    take_over(stored_.pins, former + name.substr(instance.size()), name);
            take_over(stored_.records, former, instance);
        }
    }

    template <class Values>
    static void take_over(Values& values, const std::string& former, const std::string& name) {
        if (values.count(name)) return;
        if (auto kept = values.extract(former)) {
            kept.key() = name;
            values.insert(std::move(kept));
        }
    }

    void report_left_out() {
        const auto report_one = [this](const std::string& name) {
            report(file_->path().string() + " holds " + name + ", which " + toml_ +
                   " does not name: it is left out");
        };
        const std::set<std::string> pins(settings_.pins.begin(), settings_.pins.end());
        for (const auto& [name, value] : stored_.pins)
            if (!pins.count(name)) report_one(name);
        const std::set<std::string> components(settings_.records.begin(), settings_.records.end());
        for (const auto& [component, records] : stored_.records)
            if (!components.count(component)) report_one("records of " + component);
    }

    void fail(Fault fault, const std::string& why) {
        phase_ = Phase::over;
        fault_ = fault;
        report(why);
    }

    void report(const std::string& what) {
        if (what == reported_) return;
        std::cerr << "plumb-retain: " + what + '\n';
        reported_ = what;
    }

    const std::string toml_;
    RetainSettings settings_;
    const Clock::duration every_ =
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(settings_.every));
    std::optional<AtomicFile> file_;
    StoreOrigin origin_;             // of a store that is bound
    Retained stored_;                // to be put in force
    std::optional<Retained> image_;  // the values in force, at the last look
    std::string written_;            // content of the file
    std::map<std::string, RecordWalk> walks_;
    Phase phase_ = Phase::opening;
    mutable std::mutex mutex_;
    Clock::time_point due_{};
    Clock::time_point write_due_{};
    Clock::time_point asked_{};
    Fault fault_ = Fault::none;
    Fault writing_fault_ = Fault::none;
    std::int32_t saves_ = 0;
    std::string reported_;
};

}  // namespace plumb
