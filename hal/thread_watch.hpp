// SPDX-License-Identifier: GPL-2.0-or-later
// Compares the threads of the running HAL with the places that the functions of Plumb declare. update() asks
// once a second, background() reads.
#pragma once

#include "hal/message.hpp"
#include "hal/thread_list.hpp"
#include "hal/thread_order.hpp"

#include <dlfcn.h>

#include <atomic>
#include <cstddef>
#include <string>
#include <vector>

namespace plumb::hal {

// The answer of a module of Plumb to `symbol`: the module is found by the code of one of its functions, and
// asked while it is kept from going. `otherwise` where it is no module of Plumb.
template <class Answer>
Answer asked_of_module(const void* code, const char* symbol_name, const char* about, Answer otherwise) {
    Dl_info file{}, answer{};
    if (dladdr(code, &file) == 0 || !file.dli_fname) return otherwise;
    void* const module = dlopen(file.dli_fname, RTLD_LAZY | RTLD_NOLOAD);
    if (!module) return otherwise;
    void* const symbol = dlsym(module, symbol_name);
    const bool its_own = symbol && dladdr(symbol, &answer) != 0 && answer.dli_fbase == file.dli_fbase;
    const auto ask = reinterpret_cast<Answer (*)(const char*)>(symbol);
    const Answer result = its_own ? ask(about) : otherwise;
    dlclose(module);
    return result;
}

// The place that a module of Plumb declares for its function.
inline Place declared_place(const ListedFunction& function) {
    return place_named(asked_of_module<const char*>(function.code, "plumb_place", function.name.c_str(), ""));
}

class ThreadWatch {
public:
    // Once in each period of update(). Whether the threads are in order, as far as is known.
    bool step(double dt) noexcept {
        since_ += dt;
        if (since_ >= interval) {
            since_ = 0;
            asked_.store(true, std::memory_order_relaxed);
        }
        return !wrong_.load(std::memory_order_relaxed);
    }

    // In background(). It finds a mistake twice before it calls it one: between delf and addf, or loadrt and
    // addf, all is on its way.
    void work() {
        if (!asked_.load(std::memory_order_relaxed)) return;
        const auto list = list_threads();
        if (!list) return;
        asked_.store(false, std::memory_order_relaxed);
        std::vector<std::string> sentences = judged(*list);
        const bool again = !sentences.empty() && sentences == last_;
        last_ = std::move(sentences);
        if (last_.empty()) reported_.clear();
        if (again && reported_ != last_) report_findings();
        if (again || last_.empty()) wrong_.store(again, std::memory_order_relaxed);
    }

private:
    static constexpr double interval = 1;  // s
    static constexpr std::size_t most_messages = 3;

    static std::vector<std::string> judged(const ThreadList& list) {
        std::vector<PlacedFunction> functions, idle;
        for (const ListedFunction& function : list.functions) {
            const Place place = place_of_linuxcnc(function.name);
            functions.push_back({function.name, place == Place::none ? declared_place(function) : place});
            if (!function.used) idle.push_back(functions.back());
        }
        std::vector<ThreadFunctions> threads;
        for (const ListedThread& thread : list.threads) {
            threads.push_back({thread.name, {}});
            for (const std::size_t i : thread.functions) threads.back().functions.push_back(functions[i]);
        }
        std::vector<std::string> sentences;
        for (const Misplaced& one : misplaced(threads, idle)) sentences.push_back(one.sentence);
        return sentences;
    }

    void report_findings() {
        reported_ = last_;
        for (std::size_t i = 0; i < last_.size() && i < most_messages; ++i) report_error(last_[i].c_str());
        if (last_.size() > most_messages)
            report_error((std::to_string(last_.size() - most_messages) +
                          " more functions are not where they belong; run plumb doctor --running.")
                             .c_str());
    }

    double since_ = interval;
    std::atomic<bool> asked_{false}, wrong_{false};
    std::vector<std::string> last_, reported_;  // of the background
};

}  // namespace plumb::hal
