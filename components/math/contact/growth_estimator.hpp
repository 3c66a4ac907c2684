// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/math/contact/contact_reference.hpp"
#include "components/math/contact/growth_between_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace plumb {

// A distance by which contacts have moved at once, and which is not growth.
enum class Shift : std::int32_t { none, all, only_tool, one_tool, by_feed };

// What is expected of any machine, before its contacts.
struct ContactPriors {
    double outlier = 0.005;       // of a contact: a chip or odd blank in 200
    double tool = 0.0003;         // of a contact: a tool that was changed or measured, once in 3000
    double all = 0.0003;          // of a contact: other work, zero, setter or drive, once in 3000
    double delay = 0.0003;        // of a contact: another delay of the load, once in 3000
    double shift = 0.5;           // of gate-cap, standard deviation of a shift: 30 um, a shim or a new insert
    double largest_delay = 0.02;  // s, standard deviation of a delay: a bus or a filter
    double fast = 0.1;            // of a contact: growth that the model does not describe
    double settled_rate = 0.05;   // of max-growth-rate, without a past: 10 nm/s, 3 um in 5 min
    double settled_contacts = 3;  // that this counts for: a machine shows soon how lively it is
    double slowest = 0.01;        // of max-growth-rate: no machine is quieter than that
    double lasting = 300;         // s, for which it keeps its direction: half the lag of a spindle
    double lightest = 1e-5;       // weight of a hypothesis, of the heaviest one: below the rarest answer
    double memory = 0.05;         // weight of a new contact in the mean: of twenty contacts
    double first = 2;             // contacts that the consistency of 1 counts for at the start
    double widest = 16;           // ratio of variances: one contact beyond four sigma counts as four
    double rough = 1.5;           // of contact-repeatability: seats and blanks, until contacts show them
    double rough_contacts = 5;    // contacts that this counts for: two parts
    double likely = 0.4;          // weight of a shift that is reported
    double decided = 0.9;         // weight of a shift that is reported in the cycle in which it is found
    double follows = 0.5;         // of a step on purpose: a gauge nearer to it than to rest moves with it
};

// The growth by contacts of several gauges. What a contact shows is one of
//
//     work      growth and noise. The growth may have been faster than the model, as far as physics and this
//               machine's own past allow
//     outlier   a chip, an odd blank: nothing follows from it
//     tool      all gauges of this tool have shifted alike
//     all       all gauges have shifted alike
//     delay     all gauges have shifted by their feed: only contacts at two feeds can show it
//
// A hypothesis is a sequence of such answers: a copy of the filters with the shifts that it supposes, the
// rate at which the machine has grown unforeseen by them, and its weight (D. B. Reid, IEEE Trans. Automatic
// Control 24, 1979). The next contacts show what a jump was: a machine that has jumped by growth is likely to
// jump again. Each contact splits each hypothesis in five. The `most` heaviest live on, unless they are
// lighter than `lightest` of the heaviest. The growth is their weighted median, which makes the expected
// error smallest; a shift is never in it.
//
// An event of the program moves with the offset. In closed loop the offset follows the growth, so only a
// contact of a cycle whose offset is displaced on purpose can show it: then its gauge is withdrawn.
class GrowthEstimator {
public:
    struct Settings {
        GrowthBetweenContacts::Settings between;
        double floor = 0.015;             // mu, a third of which is harmless
        double cap = 0.06;                // mu, standard deviation of an outlier
        double max_growth_rate = 0.0002;  // mu/s
    };

    struct Reading {
        double growth = 0, noise = 0;  // mu
        double reference_sigma = 0;    // mu
        double step = 0;               // mu, by which the offset is displaced on purpose
        std::int32_t gauge = -1;       // index of the reference
        std::uint64_t of_tool = 0;     // a bit for each gauge of this tool
        bool other_tools = false;      // the reference has gauges of other tools, not withdrawn
        double feed = 0;               // mu/s, signed, and the fastest one of all gauges
        double fastest = 0;
        bool other_feeds = false;  // the reference has gauges of other feeds

        GrowthBetweenContacts::Gauge its() const noexcept { return {gauge, reference_sigma, feed}; }
        bool confirmed = false;  // beyond the gate, and other contacts have confirmed it
        std::int32_t cycle = 0;  // number of the part
    };

    enum class Verdict { accepted, claim, withdrawn };

    void step(double speed, double temperature, bool temperature_valid, const Settings& settings,
              double dt) noexcept {
        for (std::int32_t i = 0; i < alive_; ++i) {
            at(i).model.step(speed, temperature, temperature_valid, settings.between, dt);
            at(i).since += dt;
        }
        if (!at(0).model.known()) known_ = false;
        predict();
    }

    Verdict judge(const Reading& r, const Settings& settings) noexcept {
        if (withdrawn(r.gauge)) return Verdict::withdrawn;
        const Expected expected = at(0).model.expected(r.its());
        if (std::abs(r.step) > 0 && std::abs((r.growth - expected.mean) / r.step - 1) < prior.follows) {
            withdrawn_ |= bit(r.gauge);
            return Verdict::withdrawn;
        }
        if (r.gauge >= 0 && r.gauge < ContactReferences::capacity)
            reference_sigmas_[r.gauge] = r.reference_sigma;
        fastest_ = r.fastest;
        const Answer answer = split(r, settings);
        // After a start nothing is known with which the first contact could be compared: another one decides.
        const bool alone = !known_ && std::abs(r.growth) > settings.floor && !std::exchange(claimed_, true);
        const bool accepted = answer == Answer::work && !alone;
        if (accepted) ++accepted_;
        finish(accepted, r.cycle);
        return accepted ? Verdict::accepted : Verdict::claim;
    }

    // A contact of a learning cycle. `first`: of a new reference, to which the growth counts from now on.
    void learn(double growth, double sigma, bool first, const Settings& settings) noexcept {
        keep_heaviest();
        at(0).model.correct(growth, sigma, {}, !first, settings.between);
        at(0).hold(growth);
        accepted_ = 0;
        finish(true);
    }

    // All gauges have new references; the growth stays known.
    void renew_gauges() noexcept {
        keep_heaviest();
        at(0).model.change([](SpeedDrivenGrowth& its) { its.renew_gauges(); });
        at(0).forget_shifts();
        shift_ = Shift::none;
        withdrawn_ = 0;
        reference_sigmas_.fill(0);
        predict();
    }
    void forget() noexcept {
        renew_gauges();
        at(0).model.forget();
        at(0).since = 1e9;
        at(0).held = 0;
        known_ = false;
        consistency_ = 1;
        scatter_ = prior.rough;
        compared_ = 0;
        at(0).unforeseen = {};
        claimed_ = false;
        accepted_ = 0;
    }

    bool known() const noexcept { return known_; }
    double growth() const noexcept { return growth_; }  // mu, predicted for now
    double sigma() const noexcept { return sigma_; }
    double held() const noexcept { return held_; }  // mu, after the last accepted contact
    // Standard deviation of the change of the growth since the last accepted contact.
    double since_sigma() const noexcept {
        return std::sqrt(std::max(0.0, sigma_ * sigma_ - held_sigma_ * held_sigma_));
    }
    std::int32_t accepted() const noexcept { return accepted_; }  // contacts since nothing was known

    // The growth by each hypothesis that is left.
    static constexpr std::size_t most = 6;
    struct Possible {
        double weight = 0, growth = 0, sigma = 0;  // of all; mu
    };
    std::array<Possible, most> possible() const noexcept {
        std::array<Possible, most> all;
        for (std::int32_t i = 0; i < alive_; ++i)
            all[i] = {at(i).weight, at(i).model.growth(), std::sqrt(consistency_) * at(i).model.sigma()};
        return all;
    }

    // Standard deviation by which a cut may differ from the gauges, in mu: by its own seat and blank, now and
    // in the learning cycle, and by an error that all references share. Seats and blanks scatter as contacts
    // have shown. References that disagree by more than their sigmas share more, too.
    double apart(const Settings& settings) const noexcept {
        const double least2 = squared(settings.between.repeatability), found2 = scatter2(settings);
        return std::sqrt(3 * found2 - least2 + shared_error2());
    }

    // The growth that a spindle as expected would have by its speed, in mu.
    double usual_growth(const Settings& settings) const noexcept {
        return at(0).model.usual_growth(settings.between);
    }

    bool withdrawn(std::int32_t gauge) const noexcept { return withdrawn_ & bit(gauge); }
    bool program_event() const noexcept { return withdrawn_ != 0; }

    // More likely than all other hypotheses together; its size in mu, of a tool the mean of its gauges.
    Shift shift() const noexcept { return shift_; }
    double shift_size() const noexcept { return shift_ == Shift::none ? 0 : shift_of(at(0)); }
    std::uint64_t shifted_gauges() const noexcept { return at(0).of_tool; }
    // By which the contacts of a gauge at a feed are displaced without growth, in mu, as far as it is known.
    double displaced(std::int32_t gauge, double feed) const noexcept { return displaced(at(0), gauge, feed); }

    // The answers to the question that a shift is. As growth it is applied; else the references were
    // corrected by displaced().
    void shift_is_growth() noexcept {
        if (shift_ == Shift::none) return;
        keep_heaviest();
        at(0).hold(at(0).held + at(0).model.shift_of_all(fastest_));
        at(0).model.change([&](SpeedDrivenGrowth& its) { its.take_shift_as_growth(fastest_); });
        at(0).forget_shifts();
        finish(true);
    }
    void shift_is_corrected() noexcept {
        keep_heaviest();
        at(0).model.change([&](SpeedDrivenGrowth& its) {
            its.forget_errors(at(0).of_tool);
            its.forget_shift();
        });
        at(0).forget_shifts();
        finish(false);
    }

    // The growth counts from another origin, lower by -distance in mu.
    void displace(double distance) noexcept {
        for (std::int32_t i = 0; i < alive_; ++i) {
            at(i).model.change([&](SpeedDrivenGrowth& its) { its.displace(distance); });
            at(i).held += distance;
        }
        held_ += distance;
        predict();
    }

    // Mean and variance that a contact of a gauge is expected to have.
    using Expected = GrowthBetweenContacts::Expected;
    Expected expected(const Reading& r) const noexcept {
        Expected its = at(0).model.expected(r.its());
        its.variance *= consistency_;
        return its;
    }

private:
    enum class Answer { work, outlier, tool, all, delay };
    static constexpr std::size_t answers = 5;
    static constexpr double of_mean_deviation = 1.2533;  // standard deviations, of a normal distribution

    static constexpr ContactPriors prior{};

    static constexpr double squared(double x) noexcept { return x * x; }

    // Growth that the model does not describe, in a time in which it may change its direction.
    struct Unforeseen {
        double rate2 = squared(prior.settled_rate);  // square, as a part of max-growth-rate
        double contacts = prior.settled_contacts;    // that it rests on

        static double of_fastest(double time, const Settings& settings) noexcept {  // mu²
            return squared(settings.max_growth_rate) * time * std::min(time, prior.lasting);
        }
        double variance(double time, const Settings& settings) const noexcept {  // mu²
            return rate2 * of_fastest(time, settings);
        }
        // The square of an error, and the variance expected of it by all else, mu². The more of it that is,
        // the less the error shows.
        void see(double error2, double rest, double time, const Settings& settings) noexcept {
            const double shows = squared(1 / (1 + rest / variance(time, settings)));
            contacts = std::min(contacts + shows, 1 / prior.memory);
            const double seen = (error2 - rest) / std::max(of_fastest(time, settings), 1e-12);
            rate2 += shows / contacts * (std::min(seen, prior.widest * rate2) - rate2);
            rate2 = std::max(rate2, squared(prior.slowest));
        }
    };

    struct Hypothesis {
        GrowthBetweenContacts model;
        Unforeseen unforeseen;
        double weight = 1;
        bool all = false;           // all gauges have shifted
        bool alone = false;         // ... of the only tool
        bool late = false;          // the load has another delay
        std::uint64_t of_tool = 0;  // the gauges that have shifted by their tool
        // The growth by the last contact of the work, mu; s since the last one that was no outlier, and the
        // response to the drive then.
        double held = 0, since = 1e9, response = 0;

        void hold(double growth) noexcept {
            held = growth;
            since = 0;
            response = model.fastest_response();
        }
        void forget_shifts() noexcept {
            all = alone = late = false;
            of_tool = 0;
        }
    };

    struct Candidate {
        double weight = -1e300;  // logarithm
        std::int32_t parent = 0;
        Answer answer = Answer::work;
        double error = 0, variance = 0, fast = 0;  // mu, mu²; of a growth that the model does not describe
    };

    Hypothesis& at(std::int32_t i) noexcept { return set_[order_[i]]; }  // 0 is the heaviest
    const Hypothesis& at(std::int32_t i) const noexcept { return set_[order_[i]]; }

    static constexpr std::uint64_t bit(std::int32_t gauge) noexcept {
        return std::uint64_t{1} << (gauge & 63);
    }

    static double likelihood(double error, double variance) noexcept {
        return std::exp(-0.5 * error * error / variance) / std::sqrt(variance);
    }

    // The best answer to what this contact is.
    Answer split(const Reading& r, const Settings& settings) noexcept {
        std::array<Candidate, most * answers> candidates;
        const double repeatability = settings.between.repeatability;
        const double noise2 = r.noise * r.noise + repeatability * repeatability;
        for (std::int32_t i = 0; i < alive_; ++i)
            weigh(i, r, noise2, settings, candidates.data() + answers * i);
        const auto end = candidates.begin() + static_cast<std::ptrdiff_t>(answers) * alive_;
        std::partial_sort(candidates.begin(), std::min(candidates.begin() + most, end), end,
                          [](const Candidate& a, const Candidate& b) { return a.weight > b.weight; });
        learn_past(candidates[0], settings);
        live_on(candidates, r, settings);
        return candidates[0].answer;
    }

    void weigh(std::int32_t i, const Reading& r, double noise2, const Settings& settings,
               Candidate* its) const noexcept {
        const Hypothesis& h = at(i);
        const Expected expected = h.model.expected(r.its());
        const double error = r.growth - expected.mean;
        const double variance = consistency_ * (expected.variance + noise2);
        const double fast2 = fast_variance(h, settings);
        const double slow = (1 - prior.fast) * likelihood(error, variance);
        const double fast = prior.fast * likelihood(error, variance + fast2);
        const double shift2 = squared(prior.shift * settings.cap);
        const double of_shift = likelihood(error, variance + shift2);
        const double of_delay = likelihood(error, variance + squared(prior.largest_delay * r.feed));
        const double outlier = likelihood(error, variance + settings.cap * settings.cap);
        const double none = 1 - prior.outlier - prior.tool - prior.all - prior.delay;
        const auto candidate = [&](Answer answer, double p) {
            return Candidate{
                std::log(h.weight) + std::log(std::max(p, 1e-300)), i, answer, error, variance, 0};
        };
        const double grown = r.growth - displaced(h, r.gauge, r.feed);
        const double gate = std::clamp(settings.max_growth_rate * h.since, settings.floor, settings.cap);
        const bool possible = r.confirmed || std::abs(grown - h.held) <= gate + 3 * std::sqrt(noise2);
        its[0] = candidate(Answer::work, possible ? none * (slow + fast) : 0);
        its[0].fast = fast2 * fast / std::max(slow + fast, 1e-300);
        its[1] = candidate(Answer::outlier, prior.outlier * outlier);
        its[2] = candidate(Answer::tool, r.other_tools && known_ ? prior.tool * of_shift : 0);
        its[3] = candidate(Answer::all, known_ ? prior.all * of_shift : 0);
        its[4] = candidate(Answer::delay, r.other_feeds && known_ ? prior.delay * of_delay : 0);
    }

    // Since the last accepted contact a growth may have come that the model does not describe: slowly, and by
    // a change of speed as much as the whole effect of that.
    double fast_variance(const Hypothesis& h, const Settings& settings) const noexcept {
        const double by_speed = h.model.effect() * (h.model.fastest_response() - h.response);
        return std::min(h.unforeseen.variance(h.since, settings) + squared(by_speed), squared(settings.cap));
    }

    // Each contact shows how far contacts differ from what is expected.
    void learn_past(const Candidate& best, const Settings& settings) noexcept {
        if (!known_ || (best.answer != Answer::work && best.answer != Answer::outlier)) return;
        const double error2 = squared(best.error), variance = best.variance / consistency_ + best.fast;
        learn_scatter(error2, variance, settings);
        const double ratio = std::min(error2 / variance, prior.widest);
        const double part = std::max(prior.memory, 1 / (prior.first + ++compared_));
        consistency_ = std::clamp(consistency_ + part * (ratio - consistency_), 1.0, prior.widest);
    }

    // The square of an error, and the variance expected of it, mu². The more of that is of the load, the
    // growth and the reference, the less the error shows of seats and blanks.
    void learn_scatter(double error2, double variance, const Settings& settings) noexcept {
        const double least2 = squared(settings.between.repeatability), known2 = scatter2(settings);
        const double rest = variance - least2, shows = squared(known2 / (known2 + rest));
        const double part = std::max(prior.memory, 1 / (prior.rough_contacts + compared_ + 1));
        const double seen2 = std::min(error2 - rest, prior.widest * known2);
        scatter_ = std::sqrt(std::max(known2 + shows * part * (seen2 - known2), least2) / least2);
    }
    double scatter2(const Settings& settings) const noexcept {
        return squared(scatter_ * settings.between.repeatability);
    }

    // Variance of an error that all references share, beyond that of their sigmas, mu².
    double shared_error2() const noexcept {
        double weights = 0, sum = 0, squares = 0;
        std::int32_t count = 0;
        for (std::int32_t i = 0; i < ContactReferences::capacity; ++i) {
            if (!(reference_sigmas_[i] > 0) || at(0).of_tool & bit(i)) continue;
            const double weight = 1 / squared(reference_sigmas_[i]), error = at(0).model.error_of(i);
            weights += weight;
            sum += weight * error;
            squares += weight * error * error;
            ++count;
        }
        if (count < 2) return 0;
        const double ratio =
            (prior.first + squares - sum * sum / weights) / (prior.first + count - 1);  // found to expected
        return std::max(ratio - 1, 0.0) / weights;
    }

    // The heaviest candidates become the hypotheses, the heaviest of all the first one.
    void live_on(const std::array<Candidate, most * answers>& candidates, const Reading& r,
                 const Settings& settings) noexcept {
        std::int32_t count = 0;
        const std::int32_t possible = static_cast<std::int32_t>(answers) * alive_;
        while (count < static_cast<std::int32_t>(most) && count < possible &&
               candidates[count].weight > candidates[0].weight + std::log(prior.lightest))
            ++count;
        // The first child of a parent takes its place; the others move into places that are free.
        std::array<bool, most> taken{}, placed{};
        std::array<std::int32_t, most> place{};
        for (std::int32_t c = 0; c < count; ++c) {
            place[c] = order_[candidates[c].parent];
            placed[c] = !std::exchange(taken[place[c]], true);
        }
        for (std::int32_t c = 0; c < count; ++c) {
            if (placed[c]) continue;
            const Hypothesis& parent = set_[place[c]];
            place[c] =
                static_cast<std::int32_t>(std::find(taken.begin(), taken.end(), false) - taken.begin());
            taken[place[c]] = true;
            set_[place[c]] = parent;
        }
        order_ = place;
        alive_ = count;
        double sum = 0;
        for (std::int32_t c = 0; c < count; ++c) {
            suppose(at(c), candidates[c], r, settings);
            sum += at(c).weight = std::exp(candidates[c].weight - candidates[0].weight);
        }
        for (std::int32_t c = 0; c < count; ++c) at(c).weight /= sum;
    }

    void suppose(Hypothesis& h, const Candidate& c, const Reading& r, const Settings& settings) noexcept {
        if (c.answer == Answer::outlier) return;
        const double shift2 = squared(prior.shift * settings.cap);
        if (c.answer == Answer::tool) {
            h.model.change([&](SpeedDrivenGrowth& its) { its.shift(r.of_tool, r.reference_sigma, shift2); });
            h.of_tool |= r.of_tool;
        }
        if (c.answer == Answer::all) {
            h.model.change([&](SpeedDrivenGrowth& its) { its.shift_all(shift2); });
            h.all = true;
            h.alone = !r.other_tools;
        }
        if (c.answer == Answer::delay) {
            h.model.change([](SpeedDrivenGrowth& its) { its.delay_all(squared(prior.largest_delay)); });
            h.late = true;
        }
        if (c.answer == Answer::work) {
            if (known_) h.unforeseen.see(squared(c.error), c.variance, h.since, settings);
            h.model.change([&](SpeedDrivenGrowth& its) { its.forget_bias(c.fast); });
        }
        const double more = (consistency_ - 1) * (r.noise * r.noise + settings.between.repeatability *
                                                                          settings.between.repeatability);
        h.model.correct(r.growth, std::sqrt(r.noise * r.noise + more), r.its(), true, settings.between);
        h.hold(c.answer == Answer::work ? r.growth - displaced(h, r.gauge, r.feed) : h.held);
    }

    void keep_heaviest() noexcept {
        alive_ = 1;
        at(0).weight = 1;
    }

    static double displaced(const Hypothesis& h, std::int32_t gauge, double feed) noexcept {
        return h.model.shift_of_all(feed) + (h.of_tool & bit(gauge) ? h.model.error_of(gauge) : 0);
    }

    double shift_of(const Hypothesis& h) const noexcept {
        if (h.all || h.late) return h.model.shift_of_all(fastest_);
        double sum = 0;
        std::int32_t count = 0;
        for (std::int32_t i = 0; i < ContactReferences::capacity; ++i)
            if (h.of_tool & bit(i)) {
                sum += h.model.error_of(i);
                ++count;
            }
        return count > 0 ? sum / count : 0;
    }

    // A shift of the first tool of a part may be one of all tools: a contact of another tool in this part, or
    // else the next part, decides which question is asked.
    void finish(bool accepted, std::int32_t cycle = 0) noexcept {
        known_ |= accepted;
        predict();
        const Hypothesis& best = at(0);
        double weight = 0;
        for (std::int32_t i = 0; i < alive_; ++i)
            if (at(i).all == best.all && at(i).late == best.late && at(i).of_tool == best.of_tool)
                weight += at(i).weight;
        const bool likely = (best.all || best.late || best.of_tool != 0) && weight > prior.likely;
        if (!likely) shifted_in_ = -1;
        if (likely && shifted_in_ < 0) shifted_in_ = cycle;
        const bool shifted =
            likely && (shift_ != Shift::none || weight > prior.decided || cycle != shifted_in_);
        shift_ = !shifted     ? Shift::none
                 : best.alone ? Shift::only_tool
                 : best.all   ? Shift::all
                 : best.late  ? Shift::by_feed
                              : Shift::one_tool;
        if (!accepted) return;
        held_ = growth_;
        held_sigma_ = sigma_;
    }

    // Once a period, for all who ask.
    void predict() noexcept {
        std::array<double, most> growth{};
        for (std::int32_t i = 0; i < alive_; ++i) growth[i] = at(i).model.growth();
        growth_ = growth[0];
        if (alive_ > 1) growth_ = median(growth);
        double variance = 0, away = 0;
        for (std::int32_t i = 0; i < alive_; ++i) {
            const double own = at(i).model.sigma();
            variance += at(i).weight * own * own;
            away += at(i).weight * std::abs(growth[i] - growth_);
        }
        sigma_ = std::hypot(std::sqrt(consistency_ * variance), of_mean_deviation * away);
    }

    double median(const std::array<double, most>& growth) const noexcept {
        for (std::int32_t i = 0; i < alive_; ++i) {
            double below = 0, above = 0;
            for (std::int32_t j = 0; j < alive_; ++j) {
                if (growth[j] < growth[i]) below += at(j).weight;
                if (growth[j] > growth[i]) above += at(j).weight;
            }
            if (below <= 0.5 && above <= 0.5) return growth[i];
        }
        return growth[0];
    }

    std::array<Hypothesis, most> set_{};
    std::array<std::int32_t, most> order_{0, 1, 2, 3, 4, 5};  // by their weights
    std::int32_t alive_ = 1;
    bool known_ = false;
    bool claimed_ = false;  // a contact that is large has come, and nothing was known
    Shift shift_ = Shift::none;
    std::int32_t shifted_in_ = -1;  // the cycle in which a shift became likely
    std::uint64_t withdrawn_ = 0;
    double growth_ = 0, sigma_ = 0;
    double fastest_ = 0;  // mu/s, signed feed
    double held_ = 0, held_sigma_ = 0;
    double consistency_ = 1;
    double scatter_ = prior.rough;  // of seats and blanks, as a part of contact-repeatability
    std::array<double, ContactReferences::capacity> reference_sigmas_{};  // mu; 0 before the first contact
    std::int32_t compared_ = 0;                                           // contacts in the consistency
    std::int32_t accepted_ = 0;                                           // contacts since nothing was known
};

}  // namespace plumb
