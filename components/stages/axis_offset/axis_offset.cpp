// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/math/blocks/bounded.hpp"
#include "components/math/blocks/edge.hpp"
#include "components/stages/axis_offset/external_offset.hpp"
#include "components/stages/stage_permit.hpp"
#include "hal/component.hpp"
#include "hal/effect.hpp"
#include "hal/offset.hpp"
#include "hal/option.hpp"
#include "pages/axis_offset.page.hpp"

#include <cmath>
#include <cstdint>
#include <string>

namespace plumb {

enum class Fault : std::int32_t { none, source, report, settings, lost, counts, homed, guest, interlock };
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::source:
            return "One of offset-0 to offset-3, or trial, is invalid or beyond 1000; its last good value is "
                   "used.";
        case Fault::report:
            return "LinuxCNC's offset-request or offset-in-force is invalid or beyond 1000; the offset is "
                   "held.";
        case Fault::settings:
            return "The scale, max-offset or max-rate is out of its range; the last good set stays in force.";
        case Fault::lost:
            return "LinuxCNC does not take the counts: a pin is not wired, or something else clears or "
                   "disables the offsets of this axis; arm again.";
        case Fault::counts: return "The counts exceed 32 bits; load the module again.";
        case Fault::homed:
            return "The machine was homed with an offset in force; turn it off and on, or clear, and home "
                   "again.";
        case Fault::guest:
            return "A change of guest-counts has no valid guest-scale, or asks for an offset beyond 1000; "
                   "the guest's offset is held.";
        case Fault::interlock:
            return "No permit comes from interlock, so the offset is held: net stage-permit of interlock to "
                   "permit, and run plumb doctor --running.";
        default: return nullptr;
    }
}

enum class AxisOffsetStatus : std::int32_t {
    applies = hal::first_own,
    refused,
    takes_back,
    waits,
    limited,
    ramping,
    nothing
};

constexpr hal::Said said(AxisOffsetStatus status) {
    using hal::Kind;
    switch (status) {
        case AxisOffsetStatus::applies: return {Kind::good, "The axis has the offset of its sources."};
        case AxisOffsetStatus::refused:
            return {Kind::warn, "A probing move is refused: its result would contain the offset.",
                    "Remove the offset, then probe."};
        case AxisOffsetStatus::takes_back:
            return {Kind::wait, "The axis moves back: its offset returns to 0.",
                    "Wait for the end of the move."};
        case AxisOffsetStatus::waits:
            return {Kind::wait, "The axis lacks its offset.", "It gets it when the next cycle begins."};
        case AxisOffsetStatus::limited:
            return hal::Said{Kind::warn, "The axis does not have all of its offset.",
                             "Move the axis away from its soft limit, or raise the largest offset."}
                .told(hal::Tell::text);
        case AxisOffsetStatus::ramping:
            return {Kind::wait, "The axis moves to its offset.", "Wait for the end of the move."};
        case AxisOffsetStatus::nothing: return {Kind::off, "No source asks for an offset."};
        default: return hal::said_of_stage(static_cast<hal::Common>(status));
    }
}

// The pins of axis.L.eoffset-* as the guest knows them.
struct GuestPins final : hal::Group {
    using Group::Group;

    hal::In<std::int32_t> counts{this, "guest-counts", 0,
                                 "Counts of the guest: instead of axis.L.eoffset-counts."};
    hal::In<double> scale{this, "guest-scale", 0, "mu",
                          "Offset of one count of the guest: instead of axis.L.eoffset-scale."};
    hal::In<bool> enable{this, "guest-enable", true,
                         "Follow the guest's counts; false: the guest's offset holds."};
    hal::In<bool> clear{this, "guest-clear", false, "Remove the guest's offset at once."};

    hal::Out<double> request{this, "guest-request", "mu",
                             "Offset that the guest asks for: instead of axis.L.eoffset-request."};
    hal::Out<double> applied{this, "guest-applied", "mu",
                             "Part of the offset in force that is the guest's: instead of axis.L.eoffset."};
    hal::Out<bool> active{this, "guest-active",
                          "The guest's offset is not 0: instead of motion.eoffset-active."};

    GuestOffset::Given read() const noexcept { return {counts, scale, enable, clear}; }

    // `grain` is the smallest offset that there can be.
    void show(double asked_for, double in_force, double grain) noexcept {
        request = asked_for;
        applied = in_force;
        active = std::abs(in_force) > grain;
    }
};

struct AxisOffset final : hal::Component {
    static constexpr hal::About about{"axis_offset",
                                      "brings an offset into an axis of LinuxCNC by external offsets", page};

    static constexpr hal::Role role = hal::Role::stage;
    using Component::Component;

    hal::LengthUnit unit{this};

    SourceRow offset{this, "offset", 0, "mu", "Offset from one of the sources."};
    hal::In<bool> clear{this, "clear", false, "Remove this stage's offset and disarm."};
    hal::In<bool> motion_enabled{this, "motion-enabled", false, "The machine is on."};
    hal::In<bool> all_homed{this, "all-homed", false, "All joints are homed."};
    hal::In<std::int32_t> motion_type{this, "motion-type", 0,
                                      "Kind of motion: motion.motion-type; 5 is a probing move."};
    hal::In<double> offset_request{this, "offset-request", 0, "mu",
                                   "Requested offset: axis.L.eoffset-request."};
    hal::In<double> offset_in_force{this, "offset-in-force", 0, "mu",
                                    "Offset that LinuxCNC applies: axis.L.eoffset."};
    hal::Option<std::string> interlock{this, "interlock", "yes", StagePermit::about, {"no"}};
    StagePermit permit{this, interlock, true};
    hal::In<bool> offset_limited{this, "offset-limited", false, "LinuxCNC holds an axis at a soft limit."};
    hal::In<bool> allow_probing{this, "allow-probing", false, "Probing results may contain the offset.",
                                hal::machine()};
    static constexpr hal::Range scales{1e-7, 0.1}, offsets{0, 1000}, rates{0, 10};
    hal::In<double> scale{this, "scale", 0.0001, "mu", "Offset of one count.", hal::expert(scales)};
    hal::In<double> max_offset{this,
                               "max-offset",
                               0.15,
                               "mu",
                               "Maximum sum of the offsets, in either direction.",
                               hal::must(offsets)};
    hal::In<double> max_rate{
        this, "max-rate", 0.1, "mu/s", "Maximum rate of change of the own offset.", hal::machine(rates)};
    GuestPins guest{this};

    hal::Out<std::int32_t> counts{this, "counts",
                                  "Counts of LinuxCNC's external offset: to axis.L.eoffset-counts."};
    hal::Out<double> counts_scale{this, "counts-scale", "mu",
                                  "Offset of one count: to axis.L.eoffset-scale."};
    hal::Out<bool> offset_enable{this, "offset-enable", "Enables the counts: to axis.L.eoffset-enable."};
    hal::Out<bool> offset_clear{this, "offset-clear",
                                "Clears the rest of the offset: to axis.L.eoffset-clear."};
    hal::Out<double> applied_offset{this, "applied-offset", "mu",
                                    "Own offset in force, without the guest's."};
    hal::Out<bool> armed{this, "armed", "The offset follows its sources."};
    hal::Out<bool> in_force{this, "in-force", "LinuxCNC applies an offset, the own one or the guest's."};
    hal::Out<bool> ramping{this, "ramping", "The own offset changes towards its sources."};
    hal::Out<bool> limited{this, "limited", "A soft limit or max-offset prevents the full offset."};
    hal::Out<bool> uncompensated{this, "uncompensated",
                                 "The axis lacks the offset that its sources ask for."};
    hal::Out<bool> probing_refused{this, "probing-refused", "A probing move began with an offset in force."};
    hal::Codes<Fault> fault{this, "fault"};
    hal::ComponentStatus<AxisOffsetStatus> status{this};

    hal::Offset moves{this, hal::MovingPin(counts, counts_scale, offset_request)
                                .bound(max_offset)
                                .rate(max_rate)
                                .accelerated_by("LinuxCNC limits its acceleration, to OFFSET_AV_RATIO of "
                                                "the acceleration of the axis, except at a soft limit.")
                                .limited(limited)
                                .follows_while(armed)
                                .guest(guest.request)};

    hal::Effects withholds{this, hal::Effect::withholds, clear};
    hal::Effects at_once{this, hal::Effect::at_once, offset, max_offset};
    hal::Effects in_no_cycle{this, hal::Effect::in_no_cycle, scale};

    hal::Function run{this, "update", &AxisOffset::update, hal::Place::stage,
                      "After a guest in the same thread."};

    void prepare() override { settings_ = {scale, max_offset, max_rate}; }

    void update(double dt) noexcept {
        hal::SettingsReader setting;
        const Settings given{setting(scale), setting(max_offset), setting(max_rate)};
        if (setting.good()) settings_ = given;
        const Permit now = permit.step();
        if (now.source != source_ && now.source != 0 && !enabled_) sources_.clear();
        source_ = now.source;
        const bool good_sources = sources_.read(offset, now);
        const bool on = motion_enabled, homed = all_homed, probing = motion_type == probe;
        const bool arms = arm_.rises(now.arm), taking_back = clear, clears = clear_.rises(taking_back);
        if (power_.rises(on)) forget();
        const bool hears = read_report(dt);
        const bool is_enabled = now.enable;
        enabled_ = is_enabled;
        held_ = now.hold;
        const double wanted = is_enabled ? sources_.value() : 0;
        const double possible = bounded(wanted, settings_.max_offset);
        const double target = taking_back ? 0 : possible;

        // A joint that homes where it stands takes the offset with it, also the guest's.
        if (homing_.rises(homed)) wrong_origin_ = any_in_force();
        if (probing_.rises(probing)) refused_ = own_in_force() && !allow_probing;
        refused_ = refused_ && probing;
        const bool able = on && homed;
        const bool ready = able && !taking_back && !wrong_origin_ && permit.alive();
        enter(next({able, ready, arms, taking_back, clears}));
        ledger_.listen(guest.read(), takes_counts());
        if (takes_counts() && hears) follow(target, probing, dt);

        counts = counter_.counts();
        counts_scale = settings_.scale;
        offset_enable = true;
        offset_clear = taking_back && !own_in_force() && std::abs(ledger_.guest().request()) <= nothing &&
                       std::abs(request_) <= settings_.scale / 2;
        applied_offset = ledger_.own_in_force();
        guest.show(ledger_.guest().request(), ledger_.guest_in_force(), settings_.scale);
        armed = state_ == State::armed;
        const bool forces = any_in_force();
        in_force = forces;
        const bool at_limit = offset_limited;
        const bool ramps = moves_own() && hears && !probing && !at_limit &&
                           std::abs(target - ledger_.own_in_force()) > slack();
        const bool falls_short = at_limit || wanted != possible;
        const bool lacks = std::abs(wanted - (on ? ledger_.own_in_force() : 0)) > slack();
        ramping = ramps;
        limited = falls_short;
        uncompensated = lacks;
        probing_refused = refused_;
        const Fault found = hal::first<Fault>({{permit.missed(), Fault::interlock},
                                               {!good_sources, Fault::source},
                                               {!hears, Fault::report},
                                               {!setting.good(), Fault::settings},
                                               {state_ == State::lost, Fault::lost},
                                               {counter_.used_up(), Fault::counts},
                                               {wrong_origin_, Fault::homed},
                                               {!ledger_.guest().good(), Fault::guest}});
        fault = found;
        const bool asked = wanted != 0 || own_in_force();
        using S = AxisOffsetStatus;
        status = hal::first<S>({{found != Fault::none, hal::common<S>(hal::Common::fault)},
                                {refused_, S::refused},
                                {!on, hal::common<S>(hal::Common::machine_off)},
                                {!homed, hal::common<S>(hal::Common::not_homed)},
                                {taking_back && asked, S::takes_back},
                                {!is_enabled && !ramps, hal::common<S>(hal::Common::off)},
                                {lacks && state_ != State::armed, S::waits},
                                {lacks && probing, hal::common<S>(hal::Common::probing)},
                                {falls_short, S::limited},
                                {ramps, S::ramping},
                                {!asked, S::nothing},
                                {true, S::applies}});
        permit.report({forces, ramps, lacks, refused_, found != Fault::none, falls_short});
    }

private:
    static constexpr double largest = 1e3;       // mu
    static constexpr double nothing = 1e-9;      // mu, that a guest's sum leaves of 0
    static constexpr double follow_time = 0.01;  // s
    static constexpr std::int32_t probe = 5;     // motion-type

    struct Settings {
        double scale, max_offset, max_rate;
    };

    enum class State {
        off,          // LinuxCNC takes no counts: the machine is off or not homed
        disarmed,     // the guest's part moves, the own one holds
        taking_back,  // the own part returns to 0
        armed,        // the own part follows the sources
        lost,         // LinuxCNC does not take the counts, until the stage is armed again or cleared
    };

    struct Signals {
        bool able;   // the machine is on and homed
        bool ready;  // to be armed
        bool arms, taking_back, clears;
    };

    State next(const Signals& now) const noexcept {
        if (state_ == State::lost && !now.clears && !(now.ready && now.arms)) return State::lost;
        if (now.ready && (state_ == State::armed || now.arms)) return State::armed;
        if (!now.able) return State::off;
        return now.taking_back ? State::taking_back : State::disarmed;
    }

    void enter(State state) noexcept {
        const bool took_counts = takes_counts(), moved_own = moves_own();
        state_ = state;
        const bool begins = (moves_own() && !moved_own) || (takes_counts() && !took_counts);
        if (begins && !counter_.agrees(request_, settings_.scale)) take_stock();
    }

    bool takes_counts() const noexcept { return state_ != State::off && state_ != State::lost; }
    bool moves_own() const noexcept { return state_ == State::taking_back || state_ == State::armed; }

    // Beside a guest's fractions of a count the own part is rounded to half a count.
    bool own_in_force() const noexcept { return std::abs(ledger_.own_in_force()) > 0.75 * settings_.scale; }

    bool any_in_force() const noexcept { return std::abs(force_) > settings_.scale / 2; }

    // What the offset in force may be off without meaning anything: LinuxCNC takes some periods to follow.
    double slack() const noexcept { return 10 * settings_.scale; }

    // LinuxCNC forgets all offsets when it is turned on.
    void forget() noexcept {
        ledger_.forget();
        counter_.start(0);
    }

    // What LinuxCNC reports.  An invalid value keeps its last good one; then false.
    bool read_report(double dt) noexcept {
        const double request = offset_request, force = offset_in_force;
        const bool hears = std::abs(request) <= largest && std::abs(force) <= largest;
        request_ = hears ? request : request_;
        force_ = hears ? force : force_;
        ledger_.divide(force_, settings_.max_rate * dt, settings_.scale);
        return hears;
    }

    void take_stock() noexcept {
        ledger_.take_stock(request_, force_, settings_.max_offset, settings_.scale);
        counter_.start(request_);
    }

    // Sends the sum of both parts.  The own one moves while the stage is armed or takes it back, the guest's
    // at any time.
    void follow(double target, bool probing, double dt) noexcept {
        if (counter_.answered(request_, settings_.scale)) {
            if (moves_own() && !probing && !held_)
                ledger_.approach(target, settings_.max_rate * dt, slack() + settings_.max_rate * follow_time);
            if (moves_own() || std::abs(ledger_.asked() - request_) > settings_.scale / 2)
                counter_.ask(ledger_.asked(), request_, settings_.scale);
        } else if (!moves_own() && !counter_.under_way()) {
            take_stock();  // not by the stage
        }
        if (counter_.silent())
            state_ = State::lost;
        else if (counter_.used_up())
            state_ = State::disarmed;
    }

    Settings settings_{};             // the last good ones
    double request_ = 0, force_ = 0;  // the last good ones
    SourceSum sources_;
    OffsetLedger ledger_;
    OffsetCounter counter_;
    std::uint32_t source_ = 0;  // that alone acts, from 1
    bool enabled_ = false, held_ = false;
    State state_ = State::off;
    bool wrong_origin_ = false;  // fault homed
    bool refused_ = false;       // the present probing move
    Edge power_, homing_, probing_, clear_;
    Edge arm_{true};  // an arm that is true already is no cycle start
};

hal::Model hal::model() {
    return model_of<AxisOffset>();
}

}  // namespace plumb
