// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_reference.hpp"
#include "hal/records.hpp"

namespace plumb {

// A reference as the walk shows and restores it.
struct ReferenceRow : hal::Group {
    using Group::Group;

    void show(ContactReference reference) noexcept {
        each(reference, [](auto& field, const auto& value) { field.row = value; });
    }

    ContactReference given() noexcept {
        ContactReference reference;
        each(reference, [](auto& field, auto& value) { value = field.restore; });
        return reference;
    }

    hal::Field<std::int32_t> operation{this, "operation", "", "Operation of the contact."};
    hal::Field<std::int32_t> tool{this, "tool", "", "Tool of the contact."};
    hal::Field<std::int32_t> occurrence{this, "occurrence", "",
                                        "Approach of that tool in that operation, from 1."};
    hal::Field<double> coordinate{this, "coordinate", "mu", "Coordinate of the contact."};
    hal::Field<double> time{this, "time", "s", "Time of the contact by the clock."};
    hal::Field<double> lost_time{this, "lost-time", "s", "Part of this time that Z did not feed."};
    hal::Field<double> feed{this, "feed", "mu/s", "Feed at the contact, negative."};
    hal::Field<double> feed_override{this, "feed-override", "1", "Override at the contact."};
    hal::Field<double> applied_offset{this, "applied-offset", "mu", "Offset at the contact."};
    hal::Field<double> sigma{this, "sigma", "mu", "Standard deviation of the contact by noise."};
    hal::Field<double> time_constant{this, "time-constant", "s",
                                     "Time constant of the load's rise at the contact."};
    hal::Field<double> speed_history{this, "speed-history", "rpm",
                                     "Spindle speed over the ten minutes before."};
    hal::Field<std::int32_t> program{this, "program-id", "", "Program that the contact belongs to."};
    hal::Field<std::int32_t> tool_set{this, "tool-set-id", "", "Set of tools at the contact."};
    hal::Field<double> temperature{this, "temperature", "degC", "Temperature at the contact."};
    hal::Field<std::int32_t> date{this, "date", "", "YYYYMMDD of the contact; 0 when not known."};
    hal::Field<std::int32_t> cycles{this, "cycles", "", "Number of cycles that this is the mean of."};
    hal::Field<double> scatter{this, "scatter", "mu",
                               "Standard deviation of the contact from cycle to cycle; 0 of one cycle."};

private:
    // Each field, and its place in a reference.
    template <class Visit>
    void each(ContactReference& r, const Visit& visit) noexcept {
        visit(operation, r.key.operation);
        visit(tool, r.key.tool);
        visit(occurrence, r.key.occurrence);
        visit(coordinate, r.contact.coordinate);
        visit(time, r.contact.time);
        visit(lost_time, r.contact.lost_time);
        visit(feed, r.contact.feed);
        visit(feed_override, r.contact.feed_override);
        visit(applied_offset, r.contact.applied_offset);
        visit(sigma, r.contact.sigma);
        visit(time_constant, r.contact.time_constant);
        visit(speed_history, r.speed_history);
        visit(program, r.setup.program);
        visit(tool_set, r.setup.tool_set);
        visit(temperature, r.temperature);
        visit(date, r.date);
        visit(cycles, r.cycles);
        visit(scatter, r.scatter);
    }
};

}  // namespace plumb
