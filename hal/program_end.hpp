// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

namespace plumb {

// The reason in an exception, for a message.
inline const char* reason(const std::exception& error) noexcept {
    const bool lack = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
    return lack ? "there is not enough memory" : error.what();
}

// A lack of memory in a function of a library that must not throw ends a program here. It need not leave an
// exception to be looked at.
inline void end_without_memory_in_words(const char* program) noexcept {
    static const char* name = nullptr;
    static std::atomic<bool> lacking{false};
    static std::terminate_handler former = nullptr;
    name = program;
    std::set_new_handler([] {
        lacking = true;
        throw std::bad_alloc();
    });
    former = std::set_terminate([] {
        if (!lacking) former();
        std::fprintf(stderr, "%s: %s\n", name, reason(std::bad_alloc()));
        std::_Exit(1);
    });
}

// All of main(): the exit status of `work`; 1, after a message, if that throws.
template <class Work>
int ended(const char* program, const Work& work) noexcept {
    end_without_memory_in_words(program);
    try {
        return work();
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", program, reason(error));
        return 1;
    }
}

}  // namespace plumb
