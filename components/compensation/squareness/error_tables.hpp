// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/files/error_table_file.hpp"
#include "components/math/geometry/axis_chain.hpp"
#include "components/math/geometry/directed_error_table.hpp"
#include "components/math/geometry/rigid_body_error.hpp"
#include "components/math/geometry/tilted_branch.hpp"
#include "hal/option.hpp"

#include <algorithm>
#include <array>
#include <atomic>
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

}  // namespace plumb
