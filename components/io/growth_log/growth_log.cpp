// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/growth_log/growth_log_settings.hpp"
#include "components/io/growth_log/growth_log_writer.hpp"
#include "components/io/growth_log/growth_rows.hpp"
#include "hal/component.hpp"
#include "hal/program_state.hpp"
#include "pages/growth_log.page.hpp"

#include <atomic>
#include <chrono>
#include <iostream>
#include <memory>
#include <mutex>
#include <stdexcept>

namespace plumb {

enum class LogFault : std::int32_t { none, component, disk, damaged, foreign, refused };

constexpr const char* sentence(LogFault fault) {
    switch (fault) {
        case LogFault::component:
            return "The component thermal_growth_test is not there, or does not answer.";
        case LogFault::disk: return "The log cannot be written.";
        case LogFault::damaged: return "The last log cannot be read; it is not resumed.";
        case LogFault::foreign:
            return "The last log is of another machine, or of other bores; it is not resumed.";
        case LogFault::refused: return "The component refuses records of the last log.";
        default: return nullptr;
    }
}

struct GrowthLogProgram final : hal::Component {
    static constexpr hal::About about{
        "growth_log", "writes the log of thermal_growth_test, and gives it back after a restart", page,
        "Log of the growth test"};

    static constexpr hal::Role role = hal::Role::program;
    using Component::Component;

    hal::ProgramState program_state{this, hal::Service::growth_log};
    hal::Out<bool> resumable{this, "resumable", "An earlier test was restored and can be resumed."};
    hal::Out<std::int32_t> lines{this, "lines", "Number of records in the log."};
    hal::Codes<LogFault> fault{this, "fault"};
    hal::Option<std::string> file{this, "file", "", "TOML file with the settings, absolute path."};
    hal::Function run{this, "update", &GrowthLogProgram::update, "Once per period."};

    void prepare() override {
        if (file.get().empty()) throw std::invalid_argument("give the TOML file of the machine by --file");
        settings_ = GrowthLogSettings::read(hal::absolute_path("file", file));
        writer_ = std::make_unique<GrowthLogWriter>(settings_.folder);
        rows_ = std::make_unique<GrowthRows>(settings_.component);
        look_back();
    }

    void update(double) noexcept { program_state.report(true, {true, has_fault_}); }

    void background() override {
        const std::lock_guard one_at_a_time(working_);  // finish() runs beside it
        try {
            work();
        } catch (const std::exception& error) {
            note(LogFault::disk, error.what());
        }
        const LogFault found = problem_ != LogFault::none ? problem_ : past_;
        fault = found;
        has_fault_ = found != LogFault::none;
        lines = static_cast<std::int32_t>(written_);
        resumable = given_ > 0 && given_ == written_;
    }

    void finish() override { background(); }

private:
    // The last log, if it is of this machine and its test has not stopped.
    void look_back() {
        try {
            last_ = writer_->unfinished();
        } catch (const std::exception& error) {
            past_ = LogFault::damaged;
            report(past_, error.what());
            return;
        }
        if (!last_) return;
        GrowthLog head = *last_;
        head.begun = settings_.head.begun;
        head.number = settings_.head.number;
        if (growth_log_file::head(head) != growth_log_file::head(settings_.head)) {
            past_ = LogFault::foreign;
            report(past_, last_->file);
            last_.reset();
        }
    }

    void work() {
        const auto now = std::chrono::steady_clock::now();
        if (now >= find_again_) {  // not more often: HAL is locked meanwhile
            found_ = rows_->find();
            find_again_ = now + std::chrono::seconds(1);
        }
        if (!found_) return note(LogFault::component, settings_.component);
        if (last_ && (giving_ || rows_->count() == 0) && !give_back()) return;
        if (last_ && !giving_ && !go_on()) return;
        last_.reset();
        const std::int64_t count = rows_->count();
        if (count < written_) {  // a new test
            written_ = 0;
            given_ = 0;
            begun_ = false;
        }
        std::string text;
        std::int64_t row = written_;
        for (; row < count && row < written_ + most_at_once; ++row) {
            const auto record = rows_->read(row);
            if (!record) break;
            if (!usable(*record)) return note(LogFault::component, "row " + std::to_string(row));
            if (row > 0 && record->kind == GrowthRecord::event && record->item == 1)
                return;  // it began again meanwhile
            text += growth_log_file::line(*record, static_cast<std::size_t>(row) + 1);
        }
        if (text.empty()) {
            if (count != written_) return;
            problem_ = LogFault::none;
            if (given_ > 0 && given_ == written_) show_gap();
            return;
        }
        if (!begun_) {
            writer_->begin(settings_.head);
            begun_ = true;
        }
        writer_->append(text);
        written_ = row;
        problem_ = past_ = LogFault::none;
    }

    static bool usable(const GrowthRecord& r) {
        return r.kind >= 1 && r.kind <= 4 &&
               (r.kind != GrowthRecord::event || (r.item >= 1 && r.item <= 10)) &&
               (r.kind != GrowthRecord::touch || (r.item >= -3 && r.item <= 3));
    }

    // The records of the last log; false while the component does not answer. The component's own count tells
    // how many it has: an answer may come after the time limit.
    bool give_back() {
        giving_ = true;
        for (;;) {
            if (!rows_->settle()) return false;
            given_ = rows_->count();
            const auto next = static_cast<std::size_t>(given_);
            if (next >= last_->records.size()) break;
            const auto accepted = rows_->give(last_->records[next]);
            if (!accepted) return false;
            if (*accepted) continue;
            past_ = LogFault::refused;
            report(past_, last_->file + ":" + std::to_string(last_->records[next].line));
            given_ = 0;
            return true;
        }
        given_ = static_cast<std::int64_t>(last_->records.size());
        number_ = last_->number;
        show_gap();
        writer_->resume(*last_);
        written_ = given_;
        begun_ = true;
        return true;
    }

    // growth_log has ended while the test went on: the last log is continued if it has the records of the
    // component. False while the component does not answer.
    bool go_on() {
        const auto size = static_cast<std::int64_t>(last_->records.size());
        if (rows_->count() < size) return true;
        for (std::int64_t step = 0; step < compared; ++step) {
            const std::int64_t row = (size - 1) * step / (compared - 1);
            const auto record = rows_->read(row);
            if (!record) return false;
            const auto number = static_cast<std::size_t>(row);
            if (growth_log_file::line(*record, number) !=
                growth_log_file::line(last_->records[number], number))
                return true;
        }
        writer_->resume(*last_);
        number_ = last_->number;
        written_ = size;
        begun_ = true;
        return true;
    }

    void show_gap() const { rows_->set_gap(writer_->since_last_write(number_).value_or(-1)); }

    void note(LogFault problem, const std::string& what) {
        if (problem != problem_) report(problem, what);
        problem_ = problem;
    }
    static void report(LogFault problem, const std::string& what) {
        std::cerr << "growth_log: " + what + ": " + sentence(problem) + '\n';
    }

    static constexpr std::int64_t most_at_once = 500;
    static constexpr std::int64_t compared = 20;  // records, the first and the last among them

    GrowthLogSettings settings_;
    std::unique_ptr<GrowthLogWriter> writer_;
    std::unique_ptr<GrowthRows> rows_;
    std::optional<GrowthLog> last_;
    std::mutex working_;
    std::int64_t written_ = 0, given_ = 0;
    int number_ = 0;  // of the log that was given back
    bool giving_ = false, begun_ = false, found_ = false;
    std::atomic<bool> has_fault_{false};
    std::chrono::steady_clock::time_point find_again_{};
    LogFault problem_ = LogFault::none;  // now
    LogFault past_ = LogFault::none;     // of the last log, until the next one begins
};

hal::Model hal::model() {
    hal::Model its = model_of<GrowthLogProgram>();
    its.period = 0.05;
    return its;
}

}  // namespace plumb
