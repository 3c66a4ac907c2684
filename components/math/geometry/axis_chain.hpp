// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>

namespace plumb {

// The axes of ISO 841: linear ones, of which U, V and W are parallel to X, Y and Z, and rotary ones about
// X, Y and Z.
enum class Axis { X, Y, Z, U, V, W, A, B, C };

constexpr char letter(Axis axis) noexcept {
    return "XYZUVWABC"[static_cast<int>(axis)];
}

constexpr bool rotary(Axis axis) noexcept {
    return axis >= Axis::A;
}

// 0, 1 or 2: the axis moves along, or turns about, +X, +Y or +Z.
constexpr int direction(Axis axis) noexcept {
    return static_cast<int>(axis) % 3;
}

// Of two linear axes.
constexpr bool parallel(Axis a, Axis b) noexcept {
    return direction(a) == direction(b) && !rotary(a) && !rotary(b);
}

// Place of a linear axis in a position of X, Y, Z and the one axis parallel to one of them; A, B and C
// follow.
constexpr int coordinate(Axis axis) noexcept {
    if (rotary(axis)) return 4 + direction(axis);
    return axis <= Axis::Z ? static_cast<int>(axis) : 3;
}

// A list of axes.
template <std::size_t N>
struct AxisList {
    std::array<Axis, N> axes{};
    int size = 0;

    const Axis* begin() const noexcept { return axes.data(); }
    const Axis* end() const noexcept { return axes.data() + size; }
    void add(Axis axis) noexcept { axes[static_cast<std::size_t>(size++)] = axis; }
};

// Axes that carry each other, from the bed outwards: a list of the linear ones, and `members` with the rotary
// ones between them.
struct AxisBranch : AxisList<4> {
    AxisList<7> members;

    bool has(Axis axis) const noexcept { return has_ >> static_cast<int>(axis) & 1; }
    // An axis rides on one parallel to it.
    bool stacked() const noexcept {
        for (const Axis* a = begin(); a != end(); ++a)
            if (std::any_of(a + 1, end(), [a](Axis b) { return parallel(*a, b); })) return true;
        return false;
    }
    void add(Axis axis) noexcept {
        members.add(axis);
        has_ |= 1u << static_cast<int>(axis);
        if (!rotary(axis)) AxisList::add(axis);
    }
    AxisBranch reversed() const noexcept {
        AxisBranch result;
        for (const Axis* axis = members.end(); axis != members.begin();) result.add(*--axis);
        return result;
    }

private:
    unsigned has_ = 0;  // a bit for each axis
};

// Which axes carry the work and which the tool: X, Y, Z, at most one of U, V and W, and rotary ones.
struct AxisChain {
    AxisBranch work;
    AxisBranch tool;

    bool has(Axis axis) const noexcept { return work.has(axis) || tool.has(axis); }
    // U, V or W.
    std::optional<Axis> parallel_axis() const noexcept {
        for (const Axis axis : {Axis::U, Axis::V, Axis::W})
            if (has(axis)) return axis;
        return {};
    }
    bool rotary() const noexcept { return has(Axis::A) || has(Axis::B) || has(Axis::C); }
    // Letters of the linear axes in the order of coordinate(), such as "xyzw"; of the rotary axes, such as "ac".
    std::string linear_letters() const {
        return letters({Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W});
    }
    std::string rotary_letters() const { return letters({Axis::A, Axis::B, Axis::C}); }
    // On either side.
    bool stacked() const noexcept { return work.stacked() || tool.stacked(); }

private:
    std::string letters(std::initializer_list<Axis> axes) const {
        std::string result;
        for (const Axis axis : axes)
            if (has(axis)) result += static_cast<char>(letter(axis) - 'A' + 'a');
        return result;
    }
};

// Reads the notation of ISO 10791 without primes: from the work over the bed to the tool, as in
//
//     w-X-Y.b-Z-C-t      w.b-X-W-Y-Z-C-t      b-X-Y-C-t
//
// A text that begins with b names the tool's side alone; those of X, Y and Z that it leaves out carry the
// work, X next to the bed. C, a spindle, may stand on either side and moves nothing.
//
// `rotary` names the axes A, B and C that are positioned, as AC: they turn all that they carry.
class AxisChainReader {
public:
    // Throws std::invalid_argument with the text, the place in it (from 1) and the reason.
    static AxisChain read(const std::string& text, const std::string& rotary = "") {
        return AxisChainReader(text, rotary).chain();
    }

    // The linear axes alone: A, B and C stand at 0, and move nothing. Throws as read() does.
    static AxisChain read_linear(const std::string& text) {
        AxisChainReader reader(text, "");
        reader.at_zero_ = true;
        return reader.chain();
    }

private:
    AxisChainReader(const std::string& text, const std::string& rotary) : text_(text) {
        if (rotary == "none") return;
        for (const char name : rotary) {
            const std::size_t k = std::string("ABC").find(name);
            if (k == std::string::npos || rotary_[k])
                throw std::invalid_argument("rotary \"" + rotary +
                                            "\" names A, B or C, each at most once, as in AC");
            rotary_[k] = true;
        }
    }

    AxisChain chain() {
        if (text_.empty()) refuse("it is empty; a chain is for instance w-Z.b-X-Y-C-t");
        const bool work_named = take('w');
        if (work_named) {
            work_side();
        } else if (!take('b')) {
            refuse("a chain begins with w, the work, or b, the bed, not with " + here());
        }
        tool_side();
        for (const Axis axis : {Axis::X, Axis::Y, Axis::Z}) {
            if (chain_.has(axis)) continue;
            if (work_named) refuse(std::string("axis ") + letter(axis) + " is missing");
            chain_.work.add(axis);
        }
        for (const Axis axis : {Axis::A, Axis::B, Axis::C})
            if (is_rotary(axis) && !chain_.has(axis))
                refuse(std::string("rotary axis ") + letter(axis) + " is missing");
        return chain_;
    }

    void work_side() {
        for (;;) {
            if (take('.')) {
                if (!take('b')) refuse("after . comes b, the bed, not " + here());
                break;
            }
            separator();
            if (take('b')) break;
            member(chain_.work);
        }
        chain_.work = chain_.work.reversed();
    }

    void tool_side() {
        for (separator(); !take('t'); separator()) member(chain_.tool);
        if (at_ != text_.size()) refuse("after t, the tool, comes nothing, not " + here());
    }

    void separator() {
        if (!take('-')) refuse("expected -, not " + here());
    }

    bool is_rotary(Axis axis) const { return rotary_[static_cast<std::size_t>(direction(axis))]; }

    void member(AxisBranch& branch) {
        for (const Axis axis : {Axis::A, Axis::B, Axis::C}) {
            if (at_ == text_.size() || text_[at_] != letter(axis)) continue;
            bool& still = still_[static_cast<std::size_t>(direction(axis))];
            if (chain_.has(axis) || still) refuse(here() + " is named twice");
            if (is_rotary(axis))
                branch.add(axis);
            else if (axis == Axis::C || at_zero_)
                still = true;
            else
                refuse(here() + " is a rotary axis that rotary does not name");
            ++at_;
            return;
        }
        for (const Axis axis : {Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V, Axis::W}) {
            if (at_ == text_.size() || text_[at_] != letter(axis)) continue;
            if (chain_.has(axis)) refuse(here() + " is named twice");
            for (const Axis other : {Axis::U, Axis::V, Axis::W})
                if (axis >= Axis::U && chain_.has(other))
                    refuse(here() + " is too many: only one of U, V and W is possible, and " + letter(other) +
                           " is named already");
            branch.add(axis);
            ++at_;
            return;
        }
        refuse("expected one of X Y Z U V W C, not " + here());
    }

    bool take(char expected) {
        if (at_ == text_.size() || text_[at_] != expected) return false;
        ++at_;
        return true;
    }

    std::string here() const {
        return at_ == text_.size() ? "the end" : std::string("\"") + text_[at_] + "\"";
    }

    [[noreturn]] void refuse(const std::string& reason) const {
        throw std::invalid_argument("chain \"" + text_ + "\", character " + std::to_string(at_ + 1) + ": " +
                                    reason);
    }

    const std::string& text_;
    std::size_t at_ = 0;
    AxisChain chain_;
    std::array<bool, 3> rotary_{}, still_{};  // A, B, C; still: a spindle, or an axis at 0
    bool at_zero_ = false;
};

}  // namespace plumb
