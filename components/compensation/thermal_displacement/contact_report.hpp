// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/growth_by_contact.hpp"
#include "hal/component.hpp"

namespace plumb {

// What became of the contacts.
struct ContactReport {
    explicit ContactReport(hal::Component* component) : owner(component) {}

    void show(const GrowthByContact& measured, GrowthByContact::Event event, const MachiningSetup& setup,
              const GrowthByContact::Settings& settings) noexcept {
        const GrowthByContact::Counts& counts = measured.counts();
        displacement = measured.growth();
        displacement_sigma = measured.sigma();
        contact = event != GrowthByContact::Event::none;
        contact_time = measured.contact().time;
        contact_coordinate = measured.contact().coordinate;
        contacts = counts.contacts;
        accepted = counts.accepted;
        rejected = counts.rejected;
        unexpected = counts.unexpected;
        missed = counts.missed;
        rejection_code = static_cast<std::int32_t>(measured.rejection());
        gate = measured.gate(settings);
        load_noise = measured.detector().noise();
        learning = measured.cycle().learning();
        learning_failed = measured.learning_failed();
        cycles_learnt = measured.cycle().learnt();
        const Refusal refusal = measured.refusal().reason();
        reference_refused = refusal != Refusal::none;
        refusal_code = static_cast<std::int32_t>(refusal);
        reference_valid = refusal == Refusal::none && measured.cycle().references().made_with(setup);
        growth_known = measured.known();
        growth_uncertain = measured.uncertain();
    }

    hal::Component* const owner;
    hal::Out<double> displacement{owner, "displacement", "mu",
                                  "Growth by the last contact that could be compared."};
    hal::Out<double> displacement_sigma{owner, "displacement-sigma", "mu",
                                        "Standard deviation of displacement by the noise of the load."};
    hal::Out<bool> contact{owner, "contact", "A contact was found in this period."};
    hal::Out<double> contact_time{owner, "contact-time", "s",
                                  "Time of the last contact; 0 when no clock ran."};
    hal::Out<double> contact_coordinate{owner, "contact-coordinate", "mu",
                                        "Coordinate of the last contact, offset included."};
    hal::Out<std::int32_t> contacts{owner, "contacts", "Number of contacts found, learnt ones too."};
    hal::Out<std::int32_t> accepted{owner, "contacts-accepted", "Number of contacts that were believed."};
    hal::Out<std::int32_t> rejected{owner, "contacts-rejected", "Number of contacts that were not believed."};
    hal::Out<std::int32_t> unexpected{owner, "contacts-unexpected",
                                      "Number of contacts that the reference does not have."};
    hal::Out<std::int32_t> missed{owner, "contacts-missed",
                                  "Number of contacts of the reference that complete cycles did not have."};
    hal::Out<std::int32_t> rejection_code{owner, "rejection-code",
                                          "Why the last rejected or unexpected contact was that."};
    hal::Out<double> gate{owner, "gate", "mu", "Largest change that would be believed now."};
    hal::Out<double> load_noise{owner, "load-noise", "%",
                                "Standard deviation of the smoothed load about its baseline."};
    hal::Out<bool> learning{owner, "learning", "This cycle is learnt from."};
    hal::Out<bool> learning_failed{owner, "learning-failed", "The last learning cycle left no reference."};
    hal::Out<std::int32_t> cycles_learnt{owner, "cycles-learnt",
                                         "Cycles learnt from for the reference that is being made."};
    hal::Out<bool> reference_valid{owner, "reference-valid",
                                   "There is a reference for this program and these tools."};
    hal::Out<bool> reference_refused{owner, "reference-refused",
                                     "The reference is not used, as refusal-code says, until acknowledged."};
    hal::Out<std::int32_t> refusal_code{owner, "refusal-code",
                                        "Why the reference is refused, as listed above; 0 if it is not."};
    hal::Out<bool> growth_known{owner, "growth-known",
                                "A contact was believed since the start, a restore or a forget."};
    hal::Out<bool> growth_uncertain{owner, "growth-uncertain",
                                    "No contact was believed since the spindle speed changed last."};
};

}  // namespace plumb
