// SPDX-License-Identifier: GPL-2.0-or-later
// The programs that functions need, by their number at interlock. This list is the only one: each sentence
// about a service takes its name from here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace plumb::hal {

inline constexpr std::int32_t services = 8;

// Programs that have a number. A net to another number is seen, because the word has it.
enum class Service : std::uint32_t { retain = 0, link = 1, task = 4, io = 5, growth_log = 6, any = 31 };

// The name of the program; null: any sensor's link may have this number.
constexpr const char* name(Service service) {
    switch (service) {
        case Service::retain: return "plumb-retain";
        case Service::link: return "linuxcnc_link";
        case Service::task: return "LinuxCNC's task";
        case Service::io: return "LinuxCNC's io";
        case Service::growth_log: return "growth_log";
        default: return nullptr;
    }
}

// A sentence about each service: its name stands between `before` and `after`.
class ServiceSentences {
public:
    constexpr ServiceSentences(const char* before, const char* after) {
        for (std::int32_t number = 0; number < services; ++number) {
            const char* const its_name = name(static_cast<Service>(number));
            const char digit[] = {static_cast<char>('0' + number), '\0'};
            char* end = texts_[number];
            for (const char* part : {before, its_name ? its_name : "", its_name ? " (service " : "service ",
                                     static_cast<const char*>(digit), its_name ? ")" : "", after})
                while (*part) *end++ = *part++;
        }
    }

    constexpr const char* operator[](std::int32_t number) const { return texts_[number]; }

private:
    char texts_[services][240]{};
};

}  // namespace plumb::hal
