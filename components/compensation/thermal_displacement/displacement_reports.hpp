// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_displacement/contact.hpp"
#include "components/compensation/thermal_displacement/growth_by_contact.hpp"
#include "hal/component.hpp"
#include "hal/records.hpp"

#include <cmath>
#include <cstdint>

namespace plumb {

// The contacts, their counts, and the growth that they show.
struct ContactReport : hal::Group {
    using Group::Group;

    void show(const GrowthByContact& measured, GrowthByContact::Event event, const MachiningSetup& setup,
              const DisplacementSettings& settings) noexcept {
        const CycleTally::Counts& counts = measured.tally().counts();
        displacement = measured.growth();
        displacement_sigma = measured.sigma();
        contact = event != GrowthByContact::Event::none;
        contact_time = measured.contact().time;
        contact_coordinate = measured.contact().coordinate;
        contact_tool = measured.contact_key().tool;
        contact_operation = measured.contact_key().operation;
        time_constant = measured.contact().time_constant;
        contacts = counts.contacts;
        accepted = counts.accepted;
        rejected = counts.rejected;
        unexpected = counts.unexpected;
        missed = counts.missed;
        gate = measured.filter().gate(settings);
        load_noise = measured.detector().noise();
        learning = measured.cycle().learning();
        learning_failed = measured.tally().learning_fault() != LearningFault::none;
        cycles_learnt = measured.cycle().learnt();
        learnt = measured.tally().learnt();
        poor_load = measured.tally().learnt() && measured.shows_z_poorly(settings);
        const Refusal refusal = measured.refusal().reason();
        reference_refused = refusal != Refusal::none;
        reference_valid = refusal == Refusal::none && measured.cycle().has(setup);
        growth_known = measured.known();
        growth_uncertain = measured.uncertain(settings);
    }

    hal::Out<double> displacement{this, "displacement", "mu",
                                  "Growth by the last contact that could be compared."};
    hal::Out<double> displacement_sigma{this, "displacement-sigma", "mu",
                                        "Standard deviation of displacement by the noise of the load."};
    hal::Out<bool> contact{this, "contact", "A contact was found in this period."};
    hal::Out<double> contact_time{this, "contact-time", "s",
                                  "Time of the last contact; 0 when no clock ran."};
    hal::Out<double> contact_coordinate{this, "contact-coordinate", "mu",
                                        "Coordinate of the last contact, offset included."};
    hal::Out<std::int32_t> contact_tool{this, "contact-tool", "Tool of the last contact."};
    hal::Out<std::int32_t> contact_operation{this, "contact-operation", "Operation of the last contact."};
    hal::Out<double> time_constant{
        this, "contact-time-constant", "s",
        "Time constant of the load's rise at the last contact: the drive's filter."};
    hal::Out<std::int32_t> contacts{this, "contacts", "Number of contacts found, learned ones too."};
    hal::Out<std::int32_t> accepted{this, "contacts-accepted", "Number of contacts that were accepted."};
    hal::Out<std::int32_t> rejected{this, "contacts-rejected", "Number of contacts that were rejected."};
    hal::Out<std::int32_t> unexpected{this, "contacts-unexpected",
                                      "Number of contacts that the reference does not have."};
    hal::Out<std::int32_t> missed{this, "contacts-missed",
                                  "Number of contacts of the reference that complete cycles missed."};
    hal::Out<double> gate{this, "gate", "mu", "Largest change that one contact may show by itself now."};
    hal::Out<double> load_noise{this, "load-noise", "%",
                                "Standard deviation of the smoothed load about its baseline."};
    hal::Out<bool> learning{this, "learning", "This cycle is learned from."};
    hal::Out<bool> learning_failed{this, "learning-failed",
                                   "Nothing was learned from the last learning cycle."};
    hal::Out<std::int32_t> cycles_learnt{this, "cycles-learnt",
                                         "Cycles learned from for the reference that is being made."};
    hal::Out<bool> learnt{this, "learnt",
                          "The last cycle has given a reference; reference-sigma shows how good it is."};
    hal::Told told_learnt{this, "learnt", hal::Tell::text,
                          "Learned from this part. The reference is uncertain by {reference-sigma}; {rows} "
                          "contacts of all programs are kept."};
    hal::Out<bool> poor_load{
        this, "poor-load", "The last cycle has given a reference that is too uncertain for work-tolerance."};
    hal::Told told_poor_load{
        this, "poor-load", hal::Tell::text,
        "This load shows Z only to about {reference-sigma}. Leave it on Measure only, or learn from a steady "
        "plunge, not from interrupted milling."};
    hal::Out<bool> reference_valid{this, "reference-valid",
                                   "There is a reference for this program and these tools."};
    hal::Out<bool> reference_refused{this, "reference-refused",
                                     "No reference is used: none is of this program and these tools, or the "
                                     "feed differs until acknowledged."};
    hal::Out<bool> growth_known{this, "growth-known",
                                "A contact was accepted since the start, a restore or a forget."};
    hal::Out<bool> growth_uncertain{this, "growth-uncertain",
                                    "The growth is unknown, or growth-sigma above half of gate-floor."};
};

// How far the growth can be trusted, and why not.
struct TrustReport : hal::Group {
    using Group::Group;

    // `offset`: in force; `reason`: of a doubt.
    void show(const GrowthByContact& measured, const DisplacementSettings& settings, double estimate,
              double offset, Doubt reason) noexcept {
        const bool known = measured.known();
        authority = known ? measured.filter().part() : 0;
        sigma_ = known ? std::hypot(std::hypot(measured.filter().sigma(settings), measured.filter().apart()),
                                    estimate - offset, measured.learning_growth())
                       : 0;
        offset_sigma = sigma_;
        contact_age = known ? measured.filter().age() : 0;
        reference_sigma = measured.reference_sigma();
        doubt = reason != Doubt::none;
    }

    double sigma() const noexcept { return sigma_; }  // of the offset, mu

    hal::Out<double> authority{this, "authority", "1", "Part of the growth that is applied, 0 to 1."};
    hal::Out<double> offset_sigma{this, "offset-sigma", "mu",
                                  "Error of the offset to expect, as a standard deviation."};
    hal::Out<double> contact_age{this, "contact-age", "s",
                                 "Time since contacts should have counted, and none has; 0 while they do."};
    hal::Out<double> reference_sigma{this, "reference-sigma", "mu",
                                     "Standard deviation of the reference, by all its contacts together."};
    hal::Out<bool> doubt{this, "doubt", "The growth may be wrong; status-code gives the reason."};

private:
    double sigma_ = 0;
};

// How a shift of work went: once after each summary-time, at the end of a part.
struct WorkSummary : hal::Group {
    using Group::Group;

    // Once a period. `counts`: a part is made with compensation, and none that verifies; the offset in force
    // and its sigma in mu.
    void step(bool counts, double in_force, double sigma, bool doubted, double dt) noexcept {
        time_ += dt;
        if (counts && !counted_) over = false;
        if (counts) {
            if (std::abs(in_force) > std::abs(largest_)) largest_ = in_force;
            doubted_ |= doubted;
            sigma_ = sigma;
        } else if (counted_) {
            end_part();
        }
        counted_ = counts;
    }

    hal::In<double> interval{
        this, "summary-time", 28800, "s", "Time between two summaries.", hal::expert(hal::Range{0, 1e9})};
    hal::Out<bool> over{this, "summary",
                        "The part that has ended completes a summary-time; until the next part."};
    hal::Out<std::int32_t> parts{this, "summary-parts", "Parts made with compensation in that time."};
    hal::Out<double> offset{this, "summary-offset", "mu", "Largest offset in that time."};
    hal::Out<double> error{this, "summary-sigma", "mu", "Error of the offset to expect in these parts, rms."};
    hal::Out<double> doubt{this, "summary-doubt", "%", "Parts with a doubt."};
    hal::Told told{this, "summary", hal::Tell::text,
                   "Last shift: {summary-parts} parts, offset up to {summary-offset}, expected error "
                   "{summary-sigma}, doubt in {summary-doubt} of the parts."};

private:
    void end_part() noexcept {
        ++count_;
        doubts_ += doubted_;
        squares_ += sigma_ * sigma_;
        doubted_ = false;
        if (!(time_ >= interval)) return;
        over = true;
        parts = count_;
        offset = largest_;
        error = std::sqrt(squares_ / count_);
        doubt = 100.0 * doubts_ / count_;
        time_ = largest_ = squares_ = 0;
        count_ = doubts_ = 0;
    }

    bool counted_ = false, doubted_ = false;
    double time_ = 0, largest_ = 0, sigma_ = 0, squares_ = 0;
    std::int32_t count_ = 0, doubts_ = 0;
};

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
    Field<double> common_sigma{this, record.common_sigma, "common-sigma", "mu",
                               "Standard deviation of the growth that was subtracted when the program was "
                               "learned: an error that all its contacts share."};
};

}  // namespace plumb
