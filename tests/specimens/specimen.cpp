// SPDX-License-Identifier: GPL-2.0-or-later
// A component that uses everything the binding offers, for its tests.
#include "hal/component.hpp"
#include "hal/records.hpp"

#include <unistd.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>

namespace plumb {

class Filter {  // a name that rival.cpp has, too
public:
    double step(double x) noexcept { return 1 * x; }
    virtual ~Filter() = default;
};

enum class Fault : std::int32_t { none, negative, large = 3 };
constexpr const char* sentence(Fault fault) {
    switch (fault) {
        case Fault::negative: return "The value to add is below -100.";
        case Fault::large: return "The value to add is beyond +-100.";
        default: return nullptr;
    }
}

enum class Half : std::int32_t { none, first, second };
constexpr const char* sentence(Half half) {
    switch (half) {
        case Half::first: return "The order is below 50.";
        case Half::second: return "The order is 50 or more.";
        default: return nullptr;
    }
}

struct Limits final : hal::Group {
    using Group::Group;

    hal::In<double> lowest{this, "%-lowest", -10, "mu", "Lowest %-position of %."};
    hal::In<double> highest{this, "%-highest", 10, "mu", "Highest position of %."};

    double bounded(double x) const noexcept { return std::clamp<double>(x, lowest, highest); }
};

struct Slide final : hal::Group {
    using Group::Group;

    hal::In<double> wanted{this, "%-wanted", 0, "mu", "Position that % is to have."};
    Limits limits{this};
    hal::Out<double> position{this, "%-position", "mu", "Position of %, within its limits."};
};

struct MeasuredTool {
    std::int32_t tool = 0;
    double length = 0;
};

struct ToolRow final : hal::RecordRow<MeasuredTool> {
    using RecordRow::RecordRow;
    Field<std::int32_t> tool{this, record.tool, "tool", "", "Tool of the record."};
    Field<double> length{this, record.length, "length", "mu", "Length of the record."};
};

struct Specimen final : hal::Component {
    static constexpr hal::About about{"specimen", "shows every feature of the binding", R"(
Two functions share a state; a table is chosen at load time; work that is not realtime is done aside.

    sum(n) = sum(n-1) + in

'Quoted' text, a .dot and a back\slash come through.
.SH is not a heading here.)"};

    using Component::Component;

    static constexpr hal::Range orders{0, 1000};
    hal::In<double> in{this, "in", 1.5, "mu", "Value to add."};
    hal::In<bool> allocate{this, "allocate", false, "Misbehave: allocate in update."};
    hal::In<bool> call_system{this, "call-system", false, "Misbehave: make a system call in update."};
    hal::In<std::int32_t> order{this, "order", 0, "Work to do aside: its square appears in done.", orders};
    hal::In<std::int32_t> renumber{this, "renumber", 0, "Added to the tools of all records."};
    hal::Out<double> sum{this, "sum", "mu", "Sum of the inputs."};
    hal::Out<double> latched{this, "latched", "mu", "Sum at the last latch."};
    hal::Out<std::int32_t> done{this, "done", "Result of the work done aside."};
    hal::Out<double> gain_found{this, "gain-found", "1", "Gain given at load time."};
    hal::Count taps{this, "taps", 12, 1, 14, "Number of taps."};
    hal::Row<hal::Out<double>> tap{this, taps, "tap", "mu", "One of the taps."};
    hal::Axes<hal::In<double>, 3> offset{this, "%-offset", 0.5, "mu", "Offset of %."};
    hal::Axes<hal::Out<double>, 3> twice{this, "twice-%", "mu", "Twice the offset of %."};
    hal::Axes<Slide, 6> slides{this};
    hal::Axes<hal::Out<bool>, 9> moved{this, "%-moved", "Axis % is not at 0."};
    Slide spindle{hal::Owner(this, 's')};
    hal::Codes<Fault> fault{this, "fault"};
    hal::Code<Half> half{this, "half", "Half that the order lies in."};
    hal::Records records{this};
    ToolRow row{this};
    hal::Option<std::string> table{this, "table", "", "File, absolute path."};
    hal::Option<double> gain{this, "gain", 1, "Factor."};
    hal::Function run{this, "update", &Specimen::update, "First."};
    hal::Function hold{this, "latch", &Specimen::latch, "After update."};

    void prepare() override {
        hal::absolute_path("table", table);
        if (gain.get() == 13) throw std::runtime_error("gain=13: unlucky");
        if (gain.get() == 14) throw 14;
    }

    void background() override {
        const std::int32_t wanted = wanted_;
        if (wanted == 13) throw std::bad_alloc();
        if (wanted == 14) throw 14;
        result_ = wanted * wanted;
    }

    void update(double) noexcept {
        if (allocate) std::free(escape(std::malloc(16)));
        if (call_system) static_cast<void>(getppid());
        wanted_ = order;
        sum_ += filter_.step(in);
        sum = sum_;
        gain_found = gain.get();
        done = result_;
        tap[taps - 1] = 11;
        for (std::size_t i = 0; i < 3; ++i) twice[i] = 2 * offset[i];
        for (Slide& slide : slides) slide.position = slide.limits.bounded(slide.wanted);
        spindle.position = spindle.limits.bounded(spindle.wanted);
        moved[3] = true;
        const double given = in;
        fault = hal::first<Fault>({{given < -100, Fault::negative}, {std::abs(given) > 100, Fault::large}});
        half = hal::first<Half>({{order > 0 && order < 50, Half::first}, {order >= 50, Half::second}});
        if (records.wants_forget()) kept_ = 0;
        if (records.wants_restore()) {
            const MeasuredTool restored = row.given();
            const bool fits = kept_ < static_cast<int>(list_.size()) && restored.length > 0;
            if (fits) list_[kept_++] = restored;
            records.restored(fits);
        }
        records.show(kept_, [&](int i) { row.show({list_[i].tool + renumber, list_[i].length}); });
    }

    void latch(double) noexcept { latched = sum_; }

private:
    static void* escape(void* p) noexcept {
        asm volatile("" : "+r"(p));  // keeps the compiler from leaving the allocation out
        return p;
    }

    Filter filter_;
    double sum_ = 0;
    std::array<MeasuredTool, 3> list_{};
    int kept_ = 0;
    std::atomic<std::int32_t> wanted_{0};
    std::atomic<std::int32_t> result_{0};
};

hal::Model hal::model() {
    return model_of<Specimen>();
}

}  // namespace plumb
