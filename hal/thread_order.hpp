// SPDX-License-Identifier: GPL-2.0-or-later
// Compares the functions of threads with their places, and finds the commands that put them there.
#pragma once

#include "hal/place.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

namespace plumb::hal {

struct PlacedFunction {
    std::string name;
    Place place = Place::none;
};

struct ThreadFunctions {
    std::string name;
    std::vector<PlacedFunction> functions;  // in the order in which it calls them
};

// A function that is not where it belongs.
struct Misplaced {
    std::string sentence;  // names it, its thread, and the functions it should follow
    std::vector<std::string> commands;  // of halcmd; all of them, one after the other, correct the order
};

namespace order {

using Functions = std::vector<PlacedFunction>;

// "a", "a and b", "a, b and c", "a, b and 3 more".
inline std::string listed(const std::vector<std::string>& names) {
    constexpr std::size_t most = 3;
    if (names.size() == 1) return names.front();
    const bool all = names.size() <= most;
    const std::size_t shown = all ? names.size() - 1 : most - 1;
    std::string result;
    for (std::size_t i = 0; i < shown; ++i) result += (i == 0 ? "" : ", ") + names[i];
    return result + " and " + (all ? names.back() : std::to_string(names.size() - shown) + " more");
}

// Functions that are called on the wrong side of this one, and belong before it or after it;
// motion-controller first, which every user knows.
struct WrongSide {
    std::vector<std::string> before, after;

    std::size_t size() const { return before.size() + after.size(); }
};

inline WrongSide wrong_side(const Functions& functions, std::size_t its) {
    WrongSide result;
    const auto add = [](std::vector<std::string>& names, const PlacedFunction& one) {
        names.insert(one.place == Place::motion ? names.begin() : names.end(), one.name);
    };
    for (std::size_t i = 0; i < functions.size(); ++i) {
        if (i > its && goes_before(functions[i].place, functions[its].place))
            add(result.before, functions[i]);
        if (i < its && goes_before(functions[its].place, functions[i].place)) add(result.after, functions[i]);
    }
    return result;
}

inline std::string sentence_of(const std::string& name, const WrongSide& wrong, const std::string& thread) {
    const bool one = wrong.size() == 1;
    const std::string them = one ? "it" : "them";
    if (wrong.after.empty())
        return name + " runs before " + listed(wrong.before) + " in " + thread + "; it belongs after " +
               them + '.';
    if (wrong.before.empty())
        return name + " runs after " + listed(wrong.after) + " in " + thread + "; it belongs before " + them +
               '.';
    return name + " runs before " + listed(wrong.before) + " and after " + listed(wrong.after) + " in " +
           thread + "; it belongs after the first and before the others.";
}

// Where a function belongs among others that are in order: right after the last that it follows, else right
// before the first that follows it, else last.
inline std::size_t position(const Functions& functions, Place place) {
    for (std::size_t i = functions.size(); i > 0; --i)
        if (goes_before(functions[i - 1].place, place)) return i;
    for (std::size_t i = 0; i < functions.size(); ++i)
        if (goes_before(place, functions[i].place)) return i;
    return functions.size();
}

// A function that has to move.
struct Move {
    PlacedFunction function;
    std::string sentence;
    std::size_t from, to;  // threads; from is `nowhere` for one that no thread has
};
inline constexpr std::size_t nowhere = static_cast<std::size_t>(-1);

inline void erase(Functions& functions, const std::string& name) {
    functions.erase(std::remove_if(functions.begin(), functions.end(),
                                   [&](const PlacedFunction& one) { return one.name == name; }),
                    functions.end());
}

// How many others a function is on the wrong side of. motion-controller, which stays, outweighs them all.
inline std::size_t conflicts(const Functions& functions, std::size_t its) {
    std::size_t result = 0;
    for (std::size_t i = 0; i < functions.size(); ++i) {
        const PlacedFunction &first = functions[std::min(i, its)], &second = functions[std::max(i, its)];
        if (goes_before(second.place, first.place))
            result += functions[i].place == Place::motion ? functions.size() : 1;
    }
    return result;
}

// Takes out of a thread those without which the rest is in order, the worst first.
inline void take_out_wrong(std::vector<ThreadFunctions>& kept, std::size_t t, std::vector<Move>& moves) {
    const Functions all = kept[t].functions;
    Functions& rest = kept[t].functions;
    for (;;) {
        std::size_t worst = 0, most = 0;
        for (std::size_t i = 0; i < rest.size(); ++i) {
            const std::size_t number = conflicts(rest, i);
            if (number <= most) continue;
            worst = i;
            most = number;
        }
        if (most == 0) return;
        const PlacedFunction function = rest[worst];
        const auto in_all = std::find_if(
            all.begin(), all.end(), [&](const PlacedFunction& one) { return one.name == function.name; });
        const WrongSide wrong = wrong_side(all, static_cast<std::size_t>(in_all - all.begin()));
        moves.push_back({function, sentence_of(function.name, wrong, kept[t].name), t, t});
        erase(rest, function.name);
    }
}

// For a function that no thread has: the thread with the most functions that have a place, of equals the
// fastest.
inline std::size_t busiest(const std::vector<ThreadFunctions>& threads) {
    const auto number = [](const ThreadFunctions& thread) {
        return std::count_if(thread.functions.begin(), thread.functions.end(),
                             [](const PlacedFunction& one) { return one.place != Place::none; });
    };
    std::size_t result = 0;
    for (std::size_t t = 1; t < threads.size(); ++t)
        if (number(threads[t]) >= number(threads[result])) result = t;
    return result;
}

// The thread where the functions between motion and the drives belong: the thread of motion-controller, without it
// the thread of interlock.
struct Home {
    std::size_t thread = nowhere;
    std::string function;
};

inline Home home_of(const std::vector<ThreadFunctions>& threads, const Functions& idle) {
    for (const Place place : {Place::motion, Place::interlock})
        for (std::size_t t = 0; t < threads.size(); ++t)
            for (const PlacedFunction& one : threads[t].functions)
                if (one.place == place) return {t, one.name};
    for (const PlacedFunction& one : idle)
        if (one.place == Place::interlock) return {busiest(threads), one.name};
    return {};
}

}  // namespace order

// Functions without a place are ignored. threads: the slowest first, as HAL has them. `idle`: functions that
// no thread has. A function is in one thread at most.
inline std::vector<Misplaced> misplaced(const std::vector<ThreadFunctions>& threads,
                                        const std::vector<PlacedFunction>& idle) {
    using namespace order;
    if (threads.empty()) return {};
    const Home its_home = home_of(threads, idle);
    const std::size_t home = its_home.thread, main = home == nowhere ? busiest(threads) : home;
    std::vector<ThreadFunctions> kept = threads;
    std::vector<Move> moves;
    for (std::size_t t = 0; t < threads.size(); ++t) {
        for (const PlacedFunction& one : threads[t].functions) {
            if (home == nowhere || t == home || !info(one.place).in_its_thread) continue;
            moves.push_back({one,
                             one.name + " is in " + threads[t].name + "; it belongs in " +
                                 threads[home].name + ", with " + its_home.function + '.',
                             t, home});
            erase(kept[t].functions, one.name);
        }
        take_out_wrong(kept, t, moves);
    }
    for (const PlacedFunction& one : idle)
        if (info(one.place).needed)
            moves.push_back({one,
                             one.name + " is in no thread, so it is never called; it belongs in " +
                                 threads[main].name + '.',
                             nowhere, main});
    std::stable_sort(moves.begin(), moves.end(),
                     [](const Move& a, const Move& b) { return a.function.place < b.function.place; });

    std::vector<ThreadFunctions> now = threads;  // as the commands leave them
    std::vector<Misplaced> result;
    for (const Move& move : moves) {
        Misplaced one{move.sentence, {}};
        const std::string& name = move.function.name;
        if (move.from != nowhere) {
            one.commands.push_back("delf " + name + ' ' + threads[move.from].name);
            erase(now[move.from].functions, name);
        }
        Functions& good = kept[move.to].functions;
        Functions& all = now[move.to].functions;
        const std::size_t place = position(good, move.function.place);
        // Beside the same neighbour in the thread as it is.
        const auto index = [&](const std::string& neighbour) {
            return static_cast<std::size_t>(
                std::find_if(all.begin(), all.end(),
                             [&](const PlacedFunction& other) { return other.name == neighbour; }) -
                all.begin());
        };
        const std::size_t at = place > 0      ? index(good[place - 1].name) + 1
                               : good.empty() ? 0
                                              : index(good[0].name);
        one.commands.push_back("addf " + name + ' ' + threads[move.to].name +
                               (at == all.size() ? "" : ' ' + std::to_string(at + 1)));
        all.insert(all.begin() + static_cast<std::ptrdiff_t>(at), move.function);
        good.insert(good.begin() + static_cast<std::ptrdiff_t>(place), move.function);
        result.push_back(std::move(one));
    }
    return result;
}

}  // namespace plumb::hal
