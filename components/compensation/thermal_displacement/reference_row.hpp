// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_reference.hpp"
#include "hal/records.hpp"

namespace plumb {

// A reference as the walk shows and restores it.
struct ReferenceRow final : hal::RecordRow<ContactReference> {
    using RecordRow::RecordRow;

    Field<std::int32_t> operation{this, record.key.operation, "operation", "", "Operation of the contact."};
    Field<std::int32_t> tool{this, record.key.tool, "tool", "", "Tool of the contact."};
    Field<std::int32_t> occurrence{this, record.key.occurrence, "occurrence", "",
                                   "Approach of that tool in that operation, from 1."};
    Field<double> coordinate{this, record.contact.coordinate, "coordinate", "mu",
                             "Coordinate of the contact."};
    Field<double> time{this, record.contact.time, "time", "s", "Time of the contact by the clock."};
    Field<double> lost_time{this, record.contact.lost_time, "lost-time", "s",
                            "Part of this time that Z did not feed."};
    Field<double> feed{this, record.contact.feed, "feed", "mu/s", "Feed at the contact, negative."};
    Field<double> feed_override{this, record.contact.feed_override, "feed-override", "1",
                                "Override at the contact."};
    Field<double> applied_offset{this, record.contact.applied_offset, "applied-offset", "mu",
                                 "Offset at the contact."};
    Field<double> work_offset{this, record.contact.work_offset, "work-offset", "mu",
                              "Work offset at the contact, or the last one that has a reason."};
    Field<double> tool_length{this, record.contact.tool_length, "tool-length", "mu",
                              "Tool length at the contact, or the last one that has a reason."};
    Field<double> sigma{this, record.contact.sigma, "sigma", "mu",
                        "Standard deviation of the contact by noise."};
    Field<double> time_constant{this, record.contact.time_constant, "time-constant", "s",
                                "Time constant of the load's rise at the contact."};
    Field<double> kink{this, record.contact.kink, "kink", "mu",
                       "Distance by which the load left its baseline before the contact."};
    Field<double> speed_history{this, record.speed_history, "speed-history", "rpm",
                                "Spindle speed over the ten minutes before."};
    Field<std::int32_t> program{this, record.setup.program, "program-id", "",
                                "Program that the contact belongs to."};
    Field<std::int32_t> tool_set{this, record.setup.tool_set, "tool-set-id", "",
                                 "Set of tools at the contact."};
    Field<double> temperature{this, record.temperature, "temperature", "degC", "Temperature at the contact."};
    Field<std::int32_t> date{this, record.date, "date", "", "YYYYMMDD of the contact; 0 when not known."};
    Field<std::int32_t> cycles{this, record.cycles, "cycles", "",
                               "Number of cycles that this is the mean of."};
    Field<double> scatter{this, record.scatter, "scatter", "mu",
                          "Standard deviation of the contact from cycle to cycle; 0 of one cycle."};
};

}  // namespace plumb
