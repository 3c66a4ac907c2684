// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/compensation/thermal_displacement/contact.hpp"
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/math/blocks/slew_limit.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

namespace plumb {

// A distance by which contacts have moved at once, and which may be no growth: of all tools, of the only tool
// of the reference, of one tool while others stand, or of all in proportion to their feeds.
enum class Shift : std::int32_t { none, all, only_tool, one_tool, by_feed };

// The result of a probed fixed surface. OperatorQuestions has the sentences.
enum class SurfaceCheck : std::int32_t {
    none,
    unknown,
    first,
    growth,
    is_growth,
    is_no_growth,
    undecided,
    unlike
};

// Why less than the whole growth is applied, or why it may be wrong. DisplacementStatus has the sentences.
enum class Doubt : std::int32_t {
    none,
    load,
    missed,
    old,
    contradiction,
    program_event,
    shift,
    poor_reference,
    uncertain,
    held_back,
    unknown,
    origin,
    shift_by_feed,
};

// The growth of a spindle by contacts of several gauges, and the offset that is safe to apply:
//
//     g = b + K x + c T           x' = (u - x) / 600 s, four times slower at rest     u = (n / 5000 rpm)^1.7
//     z = g + p + r_i + s + noise     p, r_i: errors of the references of a program, of gauge i     s: shifts
//
// A reference that is learned at a growth g^ is less by g^, whose error all its gauges share: that is p. b,
// K, c, the p and the r_i are the state of a Kalman filter (R. E. Kalman, J. Basic Eng. 82, 1960). Since the
// last contact b may have moved by as much as this machine has shown before; seats and blanks scatter as its
// contacts have. A contact beyond `test` standard deviations counts for nothing until another one agrees with
// it. If the contacts of one tool have moved and those of others stand, that tool has another length. Else
// all have moved at once: by growth, or because work, zero or tool have. Growth has the probability p, by
// distance and time. Until the operator, the contacts or a probed fixed surface answer, the offset is the
// mean of both answers by p, within what does no harm under either. A shift is never a part of g.
//
// Lengths in the unit of the machine (mu).
class GrowthFilter {
public:
    using Settings = DisplacementSettings;
    static constexpr std::int32_t most_programs = ContactReferences::most_programs;

    // A contact that could be compared with its reference.
    struct Reading {
        double growth = 0, noise = 0, reference_sigma = 0;  // mu
        double step = 0;                                    // mu, by which the offset is displaced on purpose
        double feed = 0;                                    // mu/s, signed
        std::int32_t gauge = 0;                             // index of the reference
        std::uint64_t of_tool = 0;                          // a bit for each gauge of this tool
        bool other_tools = false;  // the reference has gauges of other tools, not withdrawn
        std::int32_t cycle = 0;    // number of the part
    };

    // The machine in a period.
    struct Machine {
        double speed = 0;         // rpm
        double temperature = 20;  // degC
        bool temperature_valid = false;
        double reference_sigma = 0;  // mu, of all gauges together
        bool load_valid = true;
        bool barren = false;  // contacts should have come, and none has counted
        bool in_cycle = false;
        bool accepted = false;  // a contact, in this period
        bool origin = false;    // it has changed, and nobody knows why
    };

    // Once a period of dt > 0, in s: predict() before its contact is judged, apply() after it. A speed or
    // temperature beyond 1e6 is lost. A lost speed holds, and after a minute nothing is known until the next
    // contact; a lost temperature holds for ten minutes. One that jumps counts as changing slowly.
    void predict(const Machine& machine, const Settings& settings, double dt) noexcept {
        if (!started_ || !same(settings)) start(settings);
        const bool warmth_valid = machine.temperature_valid && std::abs(machine.temperature) <= 1e6;
        warmth_lost_ = warmth_valid ? 0 : warmth_lost_ + dt;
        if (warmth_valid && !std::exchange(first_known_, true)) first_ = machine.temperature;
        const double warmer = warmth_valid ? bounded(machine.temperature - first_, 100) : 0;
        if (warmth_valid || warmth_lost_ > 600) warmth_.step(warmer, 0.01, dt);
        const bool speed_valid = std::abs(machine.speed) <= 1e6;
        speed_lost_ = speed_valid ? 0 : speed_lost_ + dt;
        if (speed_lost_ > 60) known_ = false;
        if (speed_valid && machine.speed != speed_) {
            speed_ = machine.speed;
            drive_ = std::pow(std::abs(speed_) / 5000, 1.7);
        }
        driven_ -= std::expm1(-dt / (std::abs(speed_) < 1 ? 4 * lag : lag)) * (drive_ - driven_);
        since_ += dt;
        since_part_ += dt;
    }

    void apply(const Machine& machine, const Settings& settings, double dt) noexcept {
        if (!known_) return;
        const bool silent = machine.barren || !machine.load_valid;
        age_ = silent ? age_ + dt : 0;
        if (silence_.rises(silent)) {
            held_ = offset_;
            left_ = 1;
        }
        const double sigma = std::hypot(std::sqrt(variance() + since2(settings)), apart());
        if (silent) {
            if (!machine.in_cycle) left_ = std::clamp(2 - age_ / settings.hold_time, 0.0, 1.0);
            part_ = left_;
            offset_ = left_ * held_;
        } else {
            const double part = if_shift() == 0 ? 0 : safe(if_shift(), sigma, settings) / if_shift();
            const bool answered = std::exchange(answered_, false);
            if (!machine.in_cycle || machine.accepted || answered || part > part_)
                part_ = part;  // else work is under way, and a loss of certainty moves nothing
            offset_ = open() ? of_both(sigma, settings) : part_ * growth();
        }
        judge(machine, std::hypot(sigma_of_answers(), sigma), settings);
    }

    // Whether a contact counts as growth.
    Rejection judge(const Reading& r, const Settings& settings) noexcept {
        if (r.gauge < 0 || r.gauge >= most_gauges) return Rejection::unexpected;
        if (withdrawn(r.gauge)) return Rejection::withdrawn;

        Row row = row_of(r);
        const double z = r.growth - of_gauge_[r.gauge], error = z - state_.head(used_).dot(row);
        const double of_program = state_[common + program_];
        if (!(std::abs(r.growth - displaced(r.gauge, r.feed) - of_program - last_) <=
              settings.max_correction))
            return Rejection::too_large;
        if (std::abs(r.step) > 0 && std::abs(error / r.step - 1) < 0.5) {
            withdrawn_[program_] |= bit(r.gauge);  // nearer to the step than to rest: an event of the program
            return Rejection::withdrawn;
        }
        const double noise2 = squared(r.noise) + scatter2_, moved2 = unforeseen(settings);
        const double common2 = covariance_(common + program_, common + program_);
        const double rest2 = row.dot(covariance_.topLeftCorner(used_, used_) * row) + noise2;
        const double all2 = rest2 + moved2;
        const bool possible = std::abs(z - row[moved] * state_[moved] - of_program - last_) <=
                              by_rate(settings) + 3 * std::sqrt(noise2 + common2);
        const bool fits =
            known_ ? possible && std::abs(error) <= by_test(all2, settings) && !claimed(error, noise2, all2)
                   : std::abs(error) <= settings.floor;
        seen_[r.gauge] = r.cycle;
        if (known_ && settings.by_speed) learn_scatter(error, all2, r.cycle, settings);
        double more2 = moved2, unseen = 0;  // growth that the model does not know: variance, and a distance
        if (!fits) {
            const bool confirmed = claim({error, noise2, r.feed, r.gauge, r.of_tool, r.cycle});
            if (!confirmed) return possible || !known_ ? Rejection::unconfirmed : Rejection::beyond_gate;
            if (known_ && !moved_at_once(r, all2, settings, unseen)) {
                row[moved] = weight_of(r.feed);
                if (of_all() && claims_ == 0) correct(row, error, noise2, moved2);
                return Rejection::beyond_gate;
            }
            more2 = std::max(moved2, squared(error + unseen));
            claims_ = 0;
        } else if (claims_ > 0) {
            stands(r);
        }
        if (known_) past_.see(squared(error + unseen), rest2, lasted(), slowest2(settings));
        if (!settings.by_speed && fits) more2 = r.cycle == cycle_ ? 0 : squared(settings.cap);
        correct(row, error + unseen, noise2, more2);
        last_ = r.growth - displaced(r.gauge, r.feed) - state_[common + program_];
        if (r.cycle != std::exchange(cycle_, r.cycle)) since_part_ = since_;
        since_ = 0;
        driven_then_ = driven_;
        known_ = true;
        ++accepted_;
        return Rejection::none;
    }

    // Of a learning cycle, with the mean so far.
    Rejection compare(double growth, const Settings& settings) const noexcept {
        const double change = std::abs(growth - if_shift());
        if (!(change <= settings.max_correction)) return Rejection::too_large;
        return change <= settings.floor ? Rejection::none : Rejection::beyond_gate;
    }

    // The growth is known from here on.
    void begin_at(double growth, double sigma, const Settings& settings) noexcept {
        if (!started_) start(settings);
        surfaces_.fill({});  // their heights contain the growth of another origin
        state_[bias] += growth - if_shift();
        covariance_.row(bias).setZero();
        covariance_.col(bias).setZero();
        const Eigen::Vector2d driven(driven_, warmth_.value());
        const Eigen::Vector2d with = -covariance_.block<2, 2>(effect, effect) * driven;
        covariance_.block<2, 1>(effect, bias) = with;
        covariance_.block<1, 2>(bias, effect) = with.transpose();
        covariance_(bias, bias) = squared(2 * settings.repeatability) + squared(sigma) - driven.dot(with);
        last_ = growth;
        since_ = 0;
        driven_then_ = driven_;
        known_ = true;
        accepted_ = 0;
    }
    bool known_within(double time) const noexcept { return known_ && since_ <= time; }  // s

    // The contacts to come are compared with the references of a program, 0 ≤ program < most_programs.
    void use(std::int32_t program) noexcept {
        if (program == program_) return;
        program_ = program;
        change_gauges();
    }
    // These were learned in parts that the offset has followed: less growth() each.
    void learned_by_growth(std::int32_t program, const Settings& settings) noexcept {
        const double answers = sigma_of_answers();
        if (likely_growth()) take_as_growth();  // the references are less by growth()
        program_ = program;
        renew_gauges();
        covariance_(bias, bias) += since2(settings);
        since_ = 0;
        driven_then_ = driven_;
        Row row = Row::Zero(used_);
        row.head<moved>() << 1, driven_, warmth_.value();
        forget_state(common + program, 0);
        const Row error = -covariance_.topLeftCorner(used_, used_) * row;
        covariance_.row(common + program).head(used_) = error.transpose();
        covariance_.col(common + program).head(used_) = error;
        have_common(program, std::hypot(std::sqrt(variance()), answers));
    }
    // ... or where the growth was 0, by begin_at(); or they are restored. `sigma`, in mu, is shared by all.
    void have_references(std::int32_t program, double sigma) noexcept {
        program_ = program;
        renew_gauges();
        forget_state(common + program, 0);
        have_common(program, sigma);
    }
    std::int32_t program() const noexcept { return program_; }  // that a question is about
    double common_sigma(std::int32_t program) const noexcept { return common_sigma_[program]; }

    // All gauges of the program have new references; the growth stays known.
    void renew_gauges() noexcept {
        withdrawn_[program_] = 0;
        change_gauges();
    }
    void forget() noexcept { started_ = known_ = false; }

    bool known() const noexcept {
        return known_;
    }  // a contact was accepted; nothing has been forgotten since
    // With a question, by the answer that is more likely; its standard deviation contains the other one.
    double growth() const noexcept { return if_shift() + (likely_growth() ? state_[moved] : 0); }
    double sigma(const Settings& settings) const noexcept {
        return std::hypot(std::sqrt(variance() + since2(settings)), sigma_of_answers());
    }
    // Standard deviation by which a cut may differ from the gauges: by its own seat and blank, now and in the
    // learning cycle. Without a model of the growth, contacts show no scatter: it is that of the setting.
    double apart() const noexcept {
        return std::sqrt(3 * scatter2_ - (by_speed_ ? 0 : squared(repeatability_)));
    }
    double offset() const noexcept { return offset_; }  // to be applied
    double part() const noexcept { return part_; }      // of the growth
    double age() const noexcept { return age_; }        // s without a contact that counted
    Doubt doubt() const noexcept { return doubt_; }
    bool doubtful() const noexcept { return known_ && doubtful_; }  // of an error beyond the tolerance
    // Largest change that a contact may show by itself.
    double gate(const Settings& s) const noexcept {
        return known_ ? std::min(by_test(contact_variance() + unforeseen(s) + 2 * scatter2_, s), by_rate(s))
                      : s.floor;
    }
    double usual_growth(const Settings& settings) const noexcept {
        return settings.expected_growth * driven_;
    }

    bool withdrawn(std::int32_t gauge) const noexcept { return withdrawn_[program_] & bit(gauge); }

    // The question that is open, if it matters to the work, and its distance.
    Shift shift(const Settings& settings) const noexcept {
        return std::abs(shift_size()) > 0.5 * settings.work_tolerance ? open_ : Shift::none;
    }
    bool has_moved() const noexcept { return claims_ > 0 || open(); }  // a contact at least
    double shift_size() const noexcept { return open_ == Shift::one_tool ? tool_size_ : state_[moved]; }
    double probability() const noexcept { return !open() ? 1 : of_all() ? probability_ : 0; }
    // By which the contacts of a gauge are displaced if a shift is no growth.
    double displaced(std::int32_t gauge, double feed) const noexcept {
        return weight_of(feed) * state_[moved] + (gauge >= 0 && gauge < most_gauges ? of_gauge_[gauge] : 0);
    }
    // The answers. As growth it is applied; else the references were corrected by displaced(). A shift of one
    // tool is no growth: others stand.
    void shift_is_growth() noexcept {
        if (!of_all()) return;
        take_as_growth();
        answered_ = true;
    }
    void shift_is_corrected() noexcept {
        close();
        answered_ = true;
    }

    // A gauge tool has touched a fixed surface at this height: z = g + r + noise, without any s, so it
    // decides a question by the ratio of the likelihoods. `asked`: it is the tool that the question is about,
    // and growth and a longer tool look alike. With is_no_growth the caller corrects the references.
    SurfaceCheck check(double height, std::int32_t tool, bool asked, const Settings& s) noexcept {
        if (!known_) return SurfaceCheck::unknown;
        Surface& its = surface_of(tool);
        const std::int32_t slot = first_surface + static_cast<std::int32_t>(&its - surfaces_.data());
        Row row = Row::Zero(used_);
        row.head<moved>() << 1, driven_, warmth_.value();
        row[slot] = 1;
        const double noise2 = squared(s.surface_repeatability), moved2 = unforeseen(s);
        const bool again =
            !open() && its.odd >= 0 && its.odd != accepted_;  // contacts have stood since it moved
        if (its.tool != tool || again) {
            its = {tool};
            forget_state(slot, squared(10 * s.cap));
            state_[slot] = height - if_shift();
            correct(row, 0, noise2 + moved2, 0);
            return SurfaceCheck::first;
        }
        const auto variance_of = [&] {
            return row.dot(covariance_.topLeftCorner(used_, used_) * row) + noise2 + moved2;
        };
        const double error = height - state_.head(used_).dot(row), size = shift_size(), all2 = variance_of();
        const auto take = [&] {
            correct(row, height - state_.head(used_).dot(row), noise2, moved2);
            last_ = if_shift();
            since_ = 0;
            driven_then_ = driven_;
            its.odd = -1;
        };
        const bool stands = std::abs(error) <= by_test(all2, s);
        if (!open()) {
            if (stands)
                take();
            else
                its.odd = accepted_;  // until contacts have shown whether it was growth
            return stands ? SurfaceCheck::growth : SurfaceCheck::unlike;
        }
        row[moved] = of_all() ? 1 : 0;
        const double with2 = variance_of(), rest = error - size;
        row[moved] = 0;
        if (!stands && std::abs(rest) > by_test(with2, s)) return SurfaceCheck::unlike;
        const double ratio = squared(error) / all2 + std::log(all2) - squared(rest) / with2 - std::log(with2);
        const double before = of_all() ? probability_ : 0.5;
        const double p = before / (before + (1 - before) * std::exp(-0.5 * ratio));
        const bool longer = asked && open_ == Shift::one_tool && p > answer;
        if (longer) state_[slot] += size;
        if (longer || p < 1 - answer) {
            take();
            return SurfaceCheck::is_no_growth;
        }
        if (!of_all()) return p > answer ? SurfaceCheck::unlike : SurfaceCheck::undecided;
        if (asked && p > before) return SurfaceCheck::undecided;
        probability_ = p;
        if (p <= answer) return SurfaceCheck::undecided;
        shift_is_growth();
        take();
        return SurfaceCheck::is_growth;
    }
    // A height of a fixed surface is known.
    bool has_surface() const noexcept { return surfaces_[0].tool >= 0; }
    // The question that is open is about the tool of this gauge alone.
    bool asks_of_tool(std::int32_t gauge) const noexcept {
        return open_ == Shift::only_tool || (open_ == Shift::one_tool && of_gauge_[gauge] != 0);
    }

    // The growth counts from another origin, lower by -distance.
    void displace(double distance) noexcept {
        state_[bias] += distance;
        state_.segment<most_surfaces>(first_surface).array() -= distance;
        last_ += distance;
        claims_ = 0;
        answered_ = true;
    }

    // Growth that a contact of a gauge may show: about this mean, with this standard deviation.
    struct Expected {
        double mean, sigma;
    };
    Expected expected(const Reading& r, const Settings& settings) const noexcept {
        if (!known_) return {0, settings.cap / 2};
        const double sigma2 = contact_variance() + unforeseen(settings) + 2 * scatter2_;
        return {if_shift() + state_[common + program_] + displaced(r.gauge, r.feed),
                std::sqrt(sigma2 + squared(r.noise) + squared(r.reference_sigma))};
    }

private:
    static constexpr std::int32_t most_gauges = ContactReferences::capacity, never = -9, most_claims = 8;
    static constexpr std::int32_t bias = 0, effect = 1, warmth = 2, moved = 3, common = 4,
                                  first_surface = common + most_programs, most_surfaces = 4,
                                  first_gauge = first_surface + most_surfaces,
                                  most_states = first_gauge + most_gauges;

    // On 100 drawn days of each kind of tests/.../growth_days_test.cpp (GROWTH_SEED=30001) the geometric mean
    // of the rms errors is 4.94 um, and on 38 of 700 machines more than 1 % of the cuts are worse by 5 um.
    // Beside each: both at half and at double of it, or at the values given.
    static constexpr double lag = 600;      // s, of most spindles: 5.13, 37; 5.22, 39
    static constexpr double lasting = 300;  // s, for which growth keeps its direction: 4.86, 37; 4.97, 38
    static constexpr double settled_rate = 0.05;  // of max-growth-rate, at the start: 5.24, 35; 5.00, 46
    static constexpr double first_rate = 0.2;     // ... without the speed
    static constexpr double fast_rate = 0.15;     // of max-growth-rate, growth at once: 4.95, 38; 4.93, 38
    static constexpr double of_change = 0.35;     // of K, growth by a change of speed: 4.93, 37; 4.97, 40
    static constexpr double rough = 1.5;    // of contact-repeatability, at the start: 1 4.83, 43; 2 5.04, 34
    static constexpr double test = 3.5;     // standard deviations: 3 5.53, 29; 4 4.74, 49
    static constexpr double rare = 3.25;    // standard deviations: 3 4.83, 46; 3.5 5.06, 37
    static constexpr double decided = 0.9;  // probability that answers by itself: 0.8 4.94, 38; 0.95 4.94, 38
    static constexpr double least = 0.3;    // ... of a question: 0.1 4.95, 38; 0.5 4.92, 38
    static constexpr double answer = 0.95;  // probability of an answer at which a fixed surface gives it

    using Row = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, most_states, 1>;

    struct Claim {
        double error = 0, noise2 = 0, feed = 0;
        std::int32_t gauge = 0;
        std::uint64_t of_tool = 0;
        std::int32_t cycle = 0;
    };

    // A fixed surface, touched by this tool; the place in the list is its place in the state.
    struct Surface {
        std::int32_t tool = -1;  // none
        std::int32_t odd = -1;   // contacts accepted until it moved without them
    };

    // How fast the growth has moved that the speed does not explain, and the contacts that this rests on.
    struct Past {
        double rate2 = 0;  // mu²/s²
        double contacts = 3;

        // The square of an error, and the variance expected of it by all else, mu². The more of it that is,
        // the less the error shows.
        void see(double error2, double rest2, double lasted, double least2) noexcept {
            const double shows = squared(1 / (1 + rest2 / std::max(rate2 * lasted, 1e-15)));
            contacts = std::min(contacts + shows, 20.0);
            rate2 += shows / contacts * (std::min((error2 - rest2) / lasted, 16 * rate2) - rate2);
            rate2 = std::max(rate2, least2);
        }
    };

    static constexpr double squared(double x) noexcept { return x * x; }
    static constexpr std::uint64_t bit(std::int32_t gauge) noexcept {
        return std::uint64_t{1} << (gauge & 63);
    }
    static double slowest2(const Settings& s) noexcept { return squared(0.01 * s.max_growth_rate); }
    static double by_test(double variance, const Settings& s) noexcept {
        return std::max(test * std::sqrt(variance), s.floor / 4);
    }
    double by_rate(const Settings& s) const noexcept {
        return std::clamp(s.max_growth_rate * since_, s.floor, s.cap);
    }

    bool open() const noexcept { return open_ != Shift::none; }
    bool of_all() const noexcept { return open() && open_ != Shift::one_tool; }

    bool same(const Settings& s) const noexcept {
        return s.by_speed == by_speed_ && s.expected_growth == expected_growth_ &&
               s.temperature_growth == temperature_growth_ && s.repeatability == repeatability_;
    }

    // A machine in an unknown state.
    void start(const Settings& s) noexcept {
        withdrawn_.fill(0);
        change_gauges();
        started_ = true;
        known_ = doubtful_ = false;
        by_speed_ = s.by_speed;
        expected_growth_ = s.expected_growth;
        temperature_growth_ = s.temperature_growth;
        repeatability_ = s.repeatability;
        surfaces_.fill({});
        state_.setZero();
        covariance_.setZero();
        state_[effect] = s.by_speed ? s.expected_growth : 0;
        covariance_(bias, bias) = squared(2 * s.expected_growth);
        covariance_(effect, effect) = squared(state_[effect]);
        covariance_(warmth, warmth) = squared(s.temperature_growth);
        for (std::int32_t i = 0; i < most_programs; ++i) have_common(i, common_sigma_[i]);
        past_ = {squared((s.by_speed ? settled_rate : first_rate) * s.max_growth_rate)};
        scatter2_ = squared((s.by_speed ? rough : 1) * s.repeatability);
        scatter_contacts_ = 5;
        since_ = since_part_ = 60;
        last_ = age_ = part_ = offset_ = error_ = error_before_ = 0;
        accepted_ = 0;
        doubt_ = Doubt::none;
    }

    void change_gauges() noexcept {
        used_ = first_gauge;
        slots_.fill(-1);
        seen_.fill(never);
        claims_ = 0;
        close();
    }

    void have_common(std::int32_t program, double sigma) noexcept {
        state_[common + program] = 0;
        covariance_(common + program, common + program) = squared(sigma);
        common_sigma_[program] = sigma;
    }

    double if_shift() const noexcept {
        return state_[bias] + state_[effect] * driven_ + state_[warmth] * warmth_.value();
    }
    double variance() const noexcept {
        const Eigen::Vector3d row(1, driven_, warmth_.value());
        return std::max(0.0, row.dot(covariance_.topLeftCorner<moved, moved>() * row));
    }
    // ... and of the error that the references of this program share.
    double contact_variance() const noexcept {
        const Eigen::Vector3d row(1, driven_, warmth_.value());
        const std::int32_t i = common + program_;
        return std::max(0.0, variance() + 2 * row.dot(covariance_.block<3, 1>(0, i)) + covariance_(i, i));
    }
    bool likely_growth() const noexcept { return of_all() && probability_ > 0.5; }
    double sigma_of_answers() const noexcept {
        const double other = likely_growth() ? 1 - probability_ : probability_;
        return of_all() ? std::sqrt(other) * std::abs(state_[moved]) : 0;
    }

    double lasted() const noexcept { return std::max(since_, 1.0) * std::clamp(since_, 1.0, lasting); }  // s²
    // Variance of the growth since the last accepted contact that the model does not describe.
    double unforeseen(const Settings& s) const noexcept {
        const double by_change = of_change * state_[effect] * (driven_ - driven_then_);
        const double slow2 = squared(s.unexplained_growth) * since_ / 3600;
        return std::min(past_.rate2 * lasted() + squared(by_change) + slow2, squared(s.cap));
    }

    // ... that counts as an error: a contact that holds is the growth, but for what an hour may bring.
    double since2(const Settings& s) const noexcept {
        return by_speed_ ? unforeseen(s) : squared(s.unexplained_growth) * since_ / 3600;
    }

    Row row_of(const Reading& r) noexcept {
        std::int8_t& slot = slots_[r.gauge];
        if (slot < 0) {
            slot = static_cast<std::int8_t>(used_++);
            state_[slot] = 0;
            forget_state(slot, squared(r.reference_sigma));
        }
        Row row = Row::Zero(used_);
        row.head<common>() << 1, driven_, warmth_.value(), of_all() ? weight_of(r.feed) : 0;
        row[common + program_] = row[slot] = 1;
        return row;
    }

    void forget_state(std::int32_t i, double variance) noexcept {
        covariance_.row(i).setZero();
        covariance_.col(i).setZero();
        covariance_(i, i) = variance;
    }
    // Of this tool, or the one to forget for it.
    Surface& surface_of(std::int32_t tool) noexcept {
        const auto its = std::find_if(surfaces_.begin(), surfaces_.end() - 1, [&](const Surface& each) {
            return each.tool == tool || each.tool < 0;
        });
        return *its;
    }

    void correct(const Row& row, double error, double noise2, double more2) noexcept {
        covariance_(bias, bias) += more2;
        auto covariance = covariance_.topLeftCorner(used_, used_);
        const Row doubt = covariance * row;
        const double sum = doubt.dot(row) + noise2;
        state_.head(used_) += doubt * (error / sum);
        covariance.noalias() -= doubt * (doubt / sum).transpose();
    }

    // Seats and blanks change the error from part to part, growth keeps its sign: so the change counts. The
    // more of the expected error is of all else, the less the error shows of them.
    void learn_scatter(double error, double all2, std::int32_t cycle, const Settings& s) noexcept {
        if (std::exchange(part_number_, cycle) != cycle) error_before_ = error_;
        error_ = error;
        const double shows = squared(scatter2_ / all2);
        scatter_contacts_ = std::min(scatter_contacts_ + shows, 20.0);
        const double seen2 = std::min(error * (error - error_before_) - (all2 - scatter2_), 16 * scatter2_);
        scatter2_ += shows / scatter_contacts_ * (seen2 - scatter2_);
        scatter2_ = std::max(scatter2_, squared(0.5 * s.repeatability));
    }

    // A claim that waits explains this contact better than the filter does.
    bool claimed(double error, double noise2, double all2) const noexcept {
        return std::any_of(claims_list_.begin(), claims_list_.begin() + claims_, [&](const Claim& its) {
            const double both2 = noise2 + its.noise2;
            return squared(error - its.error) / both2 + std::log(both2) <
                   squared(error) / all2 + std::log(all2);
        });
    }

    static bool feeds_differ(const Claim& a, const Claim& b) noexcept {
        return std::abs(a.feed - b.feed) > 0.1 * std::abs(b.feed);
    }

    // Notes a claim. True if it agrees with one of another part, gauge or tool, by distance or by feed; those
    // that agree come first, `agreeing_` of them.
    bool claim(const Claim& its) noexcept {
        if (claims_ == 0) stood_ = false;
        if (claims_ == most_claims) {
            std::move(claims_list_.begin() + 1, claims_list_.end(), claims_list_.begin());
            --claims_;
        }
        claims_list_[claims_++] = its;
        const auto end =
            std::partition(claims_list_.begin(), claims_list_.begin() + claims_, [&](const Claim& other) {
                const auto alike = [&](double part) {
                    return std::abs(other.error - part * its.error) <=
                           test * std::sqrt(other.noise2 + its.noise2);
                };
                return alike(1) || (feeds_differ(other, its) && alike(other.feed / its.feed));
            });
        agreeing_ = static_cast<std::int32_t>(end - claims_list_.begin());
        return std::any_of(claims_list_.begin(), end, [&](const Claim& other) {
            return other.cycle != its.cycle || other.gauge != its.gauge;
        });
    }

    // Contacts that agree have moved at once. True if by growth: `unseen` is the part of it that was left
    // out.
    bool moved_at_once(const Reading& r, double all2, const Settings& s, double& unseen) noexcept {
        std::uint64_t tools = 0;
        double ww = 0, we = 0, wf = 0, wfe = 0, fastest = 0;  // sums for a distance and for a delay
        bool two_feeds = false;
        for (std::int32_t i = 0; i < agreeing_; ++i) {
            const Claim& its = claims_list_[i];
            tools |= its.of_tool;
            ww += 1 / its.noise2;
            we += its.error / its.noise2;
            wf += squared(its.feed) / its.noise2;
            wfe += its.error * its.feed / its.noise2;
            two_feeds |= feeds_differ(its, claims_list_[0]);
            fastest = std::min(fastest, its.feed);
        }
        const bool late = two_feeds && squared(wfe) / wf > squared(we) / ww + squared(rare);
        const double size = late ? wfe / wf * fastest : we / ww;
        bool others = false;
        for (std::int32_t i = 0; i < most_gauges; ++i) others |= !(tools & bit(i)) && seen_[i] >= r.cycle - 1;
        if (tools == r.of_tool && others) {
            if (stood_) shift_tool(tools, size);
            return false;  // else another tool decides
        }
        claims_ = 0;
        if (of_all() && std::abs(state_[moved] + size) <= test * std::sqrt(all2)) {  // they are back
            unseen = state_[moved];
            close();
            return true;
        }
        if (!of_all()) {
            const double p = probability_of_growth(size, all2, r.cycle, s);
            if (p > decided) return true;
            probability_ = std::max(p, least);
            open_ = late ? Shift::by_feed : r.other_tools ? Shift::all : Shift::only_tool;
            fastest_ = fastest;
        }  // else it is a part of the question that is open
        covariance_(moved, moved) += squared(s.cap);
        return false;
    }

    // A contact fits while others claim a move: theirs is of their tool alone, or came once.
    void stands(const Reading& r) noexcept {
        const Claim& its = claims_list_[0];
        if (its.of_tool != r.of_tool) {
            stood_ = true;
            double sum = 0;
            for (std::int32_t i = 0; i < agreeing_; ++i) sum += claims_list_[i].error;
            if (agreeing_ > 1) shift_tool(its.of_tool, sum / agreeing_);
        } else if (its.cycle < r.cycle) {
            claims_ = 0;
        }
    }

    // By how fast spindles grow at once, and by how far work, zero and tools move: half the cap.
    double probability_of_growth(double size, double all2, std::int32_t cycle,
                                 const Settings& s) const noexcept {
        const double time = std::min(cycle == cycle_ ? since_part_ : since_, 3 * lasting);
        const auto density = [&](double sigma2) {
            return std::exp(-0.5 * size * size / sigma2) / std::sqrt(sigma2);
        };
        const double growth = density(all2 + squared(fast_rate * s.max_growth_rate * time));
        return growth / std::max(growth + density(all2 + squared(0.5 * s.cap)), 1e-300);
    }

    void shift_tool(std::uint64_t tool, double size) noexcept {
        const bool small = squared(tool_size_ + size) <= squared(test) * claims_list_[0].noise2;
        bool back = false;  // the tool that is asked about has the length of before
        for (std::int32_t i = 0; i < most_gauges; ++i) {
            if (!(tool & bit(i))) continue;
            back |= open_ == Shift::one_tool && of_gauge_[i] == tool_size_ && small;
            of_gauge_[i] += size;
        }
        claims_ = 0;
        if (back) close();
        if (back || open()) return;  // one question at a time
        open_ = Shift::one_tool;
        tool_size_ = size;
    }
    void take_as_growth() noexcept {
        state_[bias] += state_[moved];
        last_ += state_[moved];
        covariance_.row(bias) += covariance_.row(moved);
        covariance_.col(bias) += covariance_.col(moved);
        close();
    }
    void close() noexcept {
        open_ = Shift::none;
        tool_size_ = state_[moved] = 0;
        forget_state(moved, 0);
        of_gauge_.fill(0);
    }
    // Part of a shift of all that a contact at this feed shows.
    double weight_of(double feed) const noexcept { return open_ == Shift::by_feed ? feed / fastest_ : 1; }

    // The farthest offset of the sign of a growth g that makes a cut worse by `harm` in one of 700 only. Up
    // to `harm` no harm is noticeable; there g must be larger than its own uncertainty.
    static double reach(double g, double sigma, const Settings& s) noexcept {
        const double harm = 0.3 * s.floor, size = std::abs(g);
        return std::max(harm + 2 * (size - rare * sigma), harm * std::clamp(size / sigma - 1, 0.0, 1.0));
    }
    static double safe(double g, double sigma, const Settings& s) noexcept {
        return std::copysign(std::min(std::abs(g), reach(g, sigma, s)), g);
    }
    double of_both(double sigma, const Settings& s) const noexcept {
        const double shift = if_shift();
        if (!of_all()) return part_ * shift;
        const double growth = shift + state_[moved], p = probability();
        if (shift * growth <= 0) return 0;
        const double mean = std::abs(p * safe(growth, sigma, s) + (1 - p) * safe(shift, sigma, s));
        return std::copysign(std::min({mean, reach(shift, sigma, s), reach(growth, sigma, s)}), shift);
    }

    void judge(const Machine& m, double sigma, const Settings& s) noexcept {
        const double unapplied = std::abs(growth() - offset_), expected = std::hypot(sigma, unapplied);
        doubtful_ = expected > (doubtful_ ? 0.8 : 1) * s.work_tolerance;
        const Shift asked = shift(s);
        doubt_ = !m.load_valid                        ? Doubt::load
                 : age_ > s.hold_time                 ? Doubt::old
                 : m.origin                           ? Doubt::origin
                 : asked == Shift::one_tool           ? Doubt::contradiction
                 : asked == Shift::by_feed            ? Doubt::shift_by_feed
                 : asked != Shift::none               ? Doubt::shift
                 : withdrawn_[program_] != 0          ? Doubt::program_event
                 : m.barren                           ? Doubt::missed
                 : !doubtful_                         ? Doubt::none
                 : accepted_ == 0                     ? Doubt::unknown
                 : unapplied > 0.5 * expected         ? Doubt::held_back
                 : m.reference_sigma > 0.7 * expected ? Doubt::poor_reference
                                                      : Doubt::uncertain;
    }

    Eigen::Matrix<double, most_states, 1> state_ = Eigen::Matrix<double, most_states, 1>::Zero();
    Eigen::Matrix<double, most_states, most_states> covariance_ =
        Eigen::Matrix<double, most_states, most_states>::Zero();
    std::int32_t used_ = first_gauge;  // states
    std::int32_t program_ = 0;
    std::array<double, most_programs> common_sigma_{};  // mu, when their references were learned
    std::array<std::int8_t, most_gauges> slots_{};      // of each gauge in the state
    std::array<std::int32_t, most_gauges> seen_{};      // part of its last contact
    std::array<double, most_gauges> of_gauge_{};        // shift of its tool
    bool stood_ = false;  // a contact of another tool fitted while claims waited
    bool started_ = false, known_ = false, first_known_ = false, doubtful_ = false, answered_ = false;
    bool by_speed_ = false;  // settings of the start
    double expected_growth_ = 0, temperature_growth_ = 0, repeatability_ = 0;
    double speed_ = 0, drive_ = 0, driven_ = 0, driven_then_ = 0;  // u and x, now and at the last contact
    double speed_lost_ = 0, warmth_lost_ = 0;                      // s
    double first_ = 0;                                             // degC
    SlewLimit warmth_;                                             // K, since the first one
    double since_ = 0,
           since_part_ = 0;  // s since the last accepted contact, and the last one of an earlier part
    double last_ = 0;        // growth by the last accepted contact
    Past past_;
    double scatter2_ = 0, scatter_contacts_ = 0;
    std::array<Claim, most_claims> claims_list_{};
    std::int32_t claims_ = 0, agreeing_ = 0, cycle_ = never;
    Shift open_ = Shift::none;
    double tool_size_ = 0, probability_ = 1;  // of the question
    double fastest_ = -1;                     // mu/s
    std::array<Surface, most_surfaces> surfaces_{};
    std::array<std::uint64_t, most_programs> withdrawn_{};  // gauges of each program
    Edge silence_;
    double error_ = 0, error_before_ = 0;  // of the last contact, and the last one of an earlier part
    std::int32_t part_number_ = never;     // of the last contact
    double age_ = 0, part_ = 0, offset_ = 0, held_ = 0, left_ = 1;
    std::int32_t accepted_ = 0;  // contacts since nothing was known
    Doubt doubt_ = Doubt::none;
};

}  // namespace plumb
