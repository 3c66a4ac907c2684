// SPDX-License-Identifier: GPL-2.0-or-later
// Truth for scoring: pins that keep the state at the last contact of a tool with the work, and at the last
// cut.
#pragma once

#include "hal/component.hpp"

#include <cstdint>

namespace plumb {

// The program's work of the moment.
struct Task {
    std::int32_t operation, occurrence, tool, event;
};

class CutTruth final : public hal::Group {
public:
    using Group::Group;

    void contact(const Task& task, double coordinate, double time, double growth) noexcept {
        coordinate_ = coordinate;
        time_ = time;
        contact_growth_ = growth;
        contact_operation_ = task.operation;
        contact_event_ = task.event;
        contacts_ = ++contact_count_;
    }

    // Call it every period. A cut counts when the tool leaves the work, with the values at its lowest tip.
    void cut(bool cutting, const Task& task, double tip, double error, double growth) noexcept {
        if (cutting && (!cutting_ || tip < bottom_.tip)) bottom_ = {task, tip, error, growth};
        if (cutting_ && !cutting) {
            error_ = bottom_.error;
            growth_ = bottom_.growth;
            operation_ = bottom_.task.operation;
            occurrence_ = bottom_.task.occurrence;
            tool_ = bottom_.task.tool;
            event_ = bottom_.task.event;
            cuts_ = ++cut_count_;
        }
        cutting_ = cutting;
    }

private:
    struct Bottom {
        Task task;
        double tip, error, growth;
    };

    hal::Out<std::int32_t> contacts_{this, "truth-contacts",
                                     "Contacts so far; truth-contact-... describes the last one."};
    hal::Out<double> coordinate_{this, "truth-contact-coordinate", "mu",
                                 "True Z of the axis at the contact."};
    hal::Out<double> time_{this, "truth-contact-time", "s",
                           "Time of the contact, since the start of the mill."};
    hal::Out<double> contact_growth_{this, "truth-contact-growth", "mu", "Growth at the contact."};
    hal::Out<std::int32_t> contact_operation_{this, "truth-contact-operation",
                                              "Operation that made the contact."};
    hal::Out<std::int32_t> contact_event_{this, "truth-contact-event", "Event under way at the contact."};
    hal::Out<std::int32_t> cuts_{this, "truth-cuts",
                                 "Cuts finished so far; truth-cut-... describes the last one."};
    hal::Out<double> error_{this, "truth-cut-error", "mu", "Tip error at the bottom of the cut."};
    hal::Out<double> growth_{this, "truth-cut-growth", "mu", "Growth at the bottom of the cut."};
    hal::Out<std::int32_t> operation_{this, "truth-cut-operation", "Operation that made the cut."};
    hal::Out<std::int32_t> occurrence_{this, "truth-cut-occurrence",
                                       "Run of the operation in its cycle, from 1."};
    hal::Out<std::int32_t> tool_{this, "truth-cut-tool", "Tool that made the cut."};
    hal::Out<std::int32_t> event_{this, "truth-cut-event", "Event under way at the bottom of the cut."};

    std::int32_t contact_count_ = 0;
    std::int32_t cut_count_ = 0;
    bool cutting_ = false;
    Bottom bottom_{};
};

}  // namespace plumb
