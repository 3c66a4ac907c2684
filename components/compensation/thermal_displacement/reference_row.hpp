// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_reference.hpp"
#include "hal/records.hpp"

namespace plumb {

// A reference, as the walk shows it and takes it back.
struct ReferenceRow {
    explicit ReferenceRow(hal::Component* component) : owner(component) {}

    void show(const ContactReference& r) noexcept {
        operation.row = r.key.operation;
        tool.row = r.key.tool;
        occurrence.row = r.key.occurrence;
        coordinate.row = r.contact.coordinate;
        time.row = r.contact.time;
        lost_time.row = r.contact.lost_time;
        feed.row = r.contact.feed;
        feed_override.row = r.contact.feed_override;
        applied_offset.row = r.contact.applied_offset;
        sigma.row = r.contact.sigma;
        time_constant.row = r.contact.time_constant;
        speed_history.row = r.speed_history;
        program.row = r.setup.program;
        tool_set.row = r.setup.tool_set;
        temperature.row = r.temperature;
        date.row = r.date;
        cycles.row = r.cycles;
        scatter.row = r.scatter;
    }

    ContactReference given() const noexcept {
        return {{operation.restore, tool.restore, occurrence.restore},
                {coordinate.restore, time.restore, lost_time.restore, feed.restore, feed_override.restore,
                 applied_offset.restore, sigma.restore, time_constant.restore},
                {program.restore, tool_set.restore},
                speed_history.restore,
                temperature.restore,
                date.restore,
                cycles.restore,
                scatter.restore};
    }

    hal::Component* const owner;
    hal::Field<std::int32_t> operation{owner, "operation", "", "Operation of the contact."};
    hal::Field<std::int32_t> tool{owner, "tool", "", "Tool of the contact."};
    hal::Field<std::int32_t> occurrence{owner, "occurrence", "",
                                        "Which approach of that tool in that operation, from 1."};
    hal::Field<double> coordinate{owner, "coordinate", "mu", "Coordinate of the contact."};
    hal::Field<double> time{owner, "time", "s", "Time of the contact by the clock."};
    hal::Field<double> lost_time{owner, "lost-time", "s", "Part of this time that Z did not feed."};
    hal::Field<double> feed{owner, "feed", "mu/s", "Feed at the contact, negative."};
    hal::Field<double> feed_override{owner, "feed-override", "1", "Override at the contact."};
    hal::Field<double> applied_offset{owner, "applied-offset", "mu", "Offset at the contact."};
    hal::Field<double> sigma{owner, "sigma", "mu", "Standard deviation of the contact by noise."};
    hal::Field<double> time_constant{owner, "time-constant", "s", "Of the load's rise at the contact."};
    hal::Field<double> speed_history{owner, "speed-history", "rpm",
                                     "Spindle speed over the ten minutes before."};
    hal::Field<std::int32_t> program{owner, "program-id", "", "Program that the contact belongs to."};
    hal::Field<std::int32_t> tool_set{owner, "tool-set-id", "", "Set of tools that it was made with."};
    hal::Field<double> temperature{owner, "temperature", "degC", "Temperature at the contact."};
    hal::Field<std::int32_t> date{owner, "date", "", "YYYYMMDD of the contact; 0 when not known."};
    hal::Field<std::int32_t> cycles{owner, "cycles", "", "Number of cycles that this is the mean of."};
    hal::Field<double> scatter{owner, "scatter", "mu",
                               "Standard deviation of the contact from cycle to cycle; 0 of one cycle."};
};

}  // namespace plumb
