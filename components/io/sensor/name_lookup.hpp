// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include "components/io/sensor/waiting.hpp"

#include <netdb.h>
#include <sys/socket.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace plumb {

// The addresses of a computer. getaddrinfo() waits for a name server as long as it likes, so a name is looked
// up on a thread of its own, which nobody waits for in the end.
class NameLookup {
public:
    struct Address {
        sockaddr_storage bytes{};
        socklen_t size = 0;
    };
    struct Result {
        std::vector<Address> addresses;
        std::string error;  // if there is none
    };

    // Returns when the name is known or the time has come. A lookup that is not done goes on; the next call
    // asks for its result.
    Result find(const std::string& host, const std::string& port, Pauses& pauses, double until) {
        if (!under_way_) {
            Result numeric = looked_up(host, port, AI_NUMERICHOST);
            if (!numeric.addresses.empty()) return numeric;
            under_way_ = std::make_shared<Shared>();
            try {
                std::thread([shared = under_way_, host, port] {
                    shared->result = looked_up(host, port, 0);
                    shared->done = true;
                }).detach();
            } catch (const std::system_error& error) {
                under_way_.reset();
                return {{}, error.what()};
            }
        }
        do {
            if (under_way_->done) return std::exchange(under_way_, nullptr)->result;
        } while (pauses.wait(std::min(until, seconds_now() + 0.01)) != Pauses::Woken::stopped &&
                 seconds_now() < until);
        return {{}, "the name server does not answer"};
    }

private:
    struct Shared {
        Result result;  // written before done
        std::atomic<bool> done{false};
    };

    static Result looked_up(const std::string& host, const std::string& port, int flags) {
        addrinfo hints{};
        hints.ai_socktype = SOCK_STREAM;
        hints.ai_flags = flags | AI_NUMERICSERV;
        addrinfo* found = nullptr;
        const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
        if (error != 0) return {{}, error == EAI_SYSTEM ? std::strerror(errno) : gai_strerror(error)};
        const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, freeaddrinfo);
        Result result;
        for (const addrinfo* each = found; each; each = each->ai_next) {
            Address address;
            address.size = each->ai_addrlen;
            std::memcpy(&address.bytes, each->ai_addr, each->ai_addrlen);
            result.addresses.push_back(address);
        }
        return result;
    }

    std::shared_ptr<Shared> under_way_;
};

}  // namespace plumb
