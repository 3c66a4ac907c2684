// SPDX-License-Identifier: GPL-2.0-or-later
// Statements that must hold after every period, such as `abs(machine - command) < 0.001 && abs(machine_rate)
// < 10`. They are written in muParser's language, about variables that stand for pins, parameters or signals.
// For each variable x there is also x_rate, its change per second since the period before, and the function
// finite(x).
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hal/host/names.hpp"
#include "hal/host/time.hpp"

namespace plumb::host {

// How often a statement failed, and when and with which values it did so for the first time.
struct Violation {
    std::string id;
    long count;
    Nanoseconds first_time;
    std::map<std::string, double> values;  // by variable; x_rate is there if the statement uses it
};

class Expectations {
public:
    Expectations();
    ~Expectations();

    // Adds a statement, or replaces the one with this id. Throws std::runtime_error when it is no
    // statement (see statement.hpp), uses a variable that is not given, or a name is unknown.
    void add(const std::string& id, const std::string& expression,
             const std::map<std::string, std::string>& variables, const Names& names);

    bool empty() const { return statements_.empty(); }

    // Looks the variables up again. Throws std::runtime_error when one is gone.
    void resolve(const Names& names);

    // The same, but checks those no more that have lost a name.
    void drop_lost(const Names& names);
    void lose_all();

    // Checks all statements at the end of a period. A statement whose result is not a number has failed.
    void check(Nanoseconds instant);

    // All failures, in the order in which the statements were added.
    std::vector<Violation> violations() const;

private:
    struct Statement;
    std::vector<std::unique_ptr<Statement>> statements_;
};

}  // namespace plumb::host
