// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/growth_by_contact.hpp"
#include "hal/component.hpp"

namespace plumb {

// The contacts, their counts, and the growth that they show.
struct ContactReport : hal::Group {
    using Group::Group;

    void show(const GrowthByContact& measured, GrowthByContact::Event event, const MachiningSetup& setup,
              const GrowthByContact::Settings& settings) noexcept {
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
        gate = measured.filter().gate(settings.growth);
        load_noise = measured.detector().noise();
        learning = measured.cycle().learning();
        learning_failed = measured.tally().learning_fault() != LearningFault::none;
        cycles_learnt = measured.cycle().learnt();
        learnt = measured.tally().learnt();
        const Refusal refusal = measured.refusal().reason();
        reference_refused = refusal != Refusal::none;
        reference_valid = refusal == Refusal::none && measured.cycle().references().made_with(setup);
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
    hal::Told told_learnt{
        this, "learnt", hal::Tell::text,
        "Learned from this part: {rows} contacts. The reference is uncertain by {reference-sigma}."};
    hal::Out<bool> reference_valid{this, "reference-valid",
                                   "There is a reference for this program and these tools."};
    hal::Out<bool> reference_refused{this, "reference-refused",
                                     "The reference is not used until acknowledged."};
    hal::Out<bool> growth_known{this, "growth-known",
                                "A contact was accepted since the start, a restore or a forget."};
    hal::Out<bool> growth_uncertain{this, "growth-uncertain",
                                    "The growth is unknown, or growth-sigma above half of gate-floor."};
};

}  // namespace plumb
