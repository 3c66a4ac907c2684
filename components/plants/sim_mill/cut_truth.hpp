// SPDX-License-Identifier: GPL-2.0-or-later
// What a scorer must know about each contact of a tool with the work and about each cut: pins that keep what
// was true of the last one.
#pragma once

#include "hal/component.hpp"

#include <cstdint>

namespace plumb {

// What the program was about.
struct Task {
    std::int32_t operation, occurrence, tool, event;
};

class CutTruth {
public:
    explicit CutTruth(hal::Component* owner)
        : contacts_{owner, "truth-contacts", "Contacts so far; truth-contact-... tells of the last one."},
          coordinate_{owner, "truth-contact-coordinate", "mu", "True Z of the axis at the contact."},
          time_{owner, "truth-contact-time", "s", "Time of the contact, since the start of the mill."},
          contact_growth_{owner, "truth-contact-growth", "mu", "Growth at the contact."},
          contact_operation_{owner, "truth-contact-operation", "Operation that made the contact."},
          contact_event_{owner, "truth-contact-event", "Event under way at the contact."},
          cuts_{owner, "truth-cuts", "Cuts finished so far; truth-cut-... tells of the last one."},
          error_{owner, "truth-cut-error", "mu", "Tip error at the bottom of the cut."},
          growth_{owner, "truth-cut-growth", "mu", "Growth at the bottom of the cut."},
          operation_{owner, "truth-cut-operation", "Operation that made the cut."},
          occurrence_{owner, "truth-cut-occurrence",
                      "Which run of the operation in its cycle it was, from 1."},
          tool_{owner, "truth-cut-tool", "Tool that made the cut."},
          event_{owner, "truth-cut-event", "Event under way at the bottom of the cut."} {}

    void contact(const Task& task, double coordinate, double time, double growth) noexcept {
        coordinate_ = coordinate;
        time_ = time;
        contact_growth_ = growth;
        contact_operation_ = task.operation;
        contact_event_ = task.event;
        contacts_ = ++contact_count_;
    }

    // To be called every period.  A cut counts when the tool leaves the work, with what was true of its
    // lowest tip.
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

    hal::Out<std::int32_t> contacts_;
    hal::Out<double> coordinate_, time_, contact_growth_;
    hal::Out<std::int32_t> contact_operation_, contact_event_;
    hal::Out<std::int32_t> cuts_;
    hal::Out<double> error_, growth_;
    hal::Out<std::int32_t> operation_, occurrence_, tool_, event_;

    std::int32_t contact_count_ = 0;
    std::int32_t cut_count_ = 0;
    bool cutting_ = false;
    Bottom bottom_{};
};

}  // namespace plumb
