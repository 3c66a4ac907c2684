// SPDX-License-Identifier: GPL-2.0-or-later
// A link of can_sensor on vcan0, on which frames go wrong in every way. Exit status 0 if no stale value is
// valid and the link recovers. can_link_faults FAULTS SEED
#include "components/io/can_sensor/can_link.hpp"

#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace plumb;

constexpr double max_age = 0.02,
                 slack = 0.5;  // s; the computer may delay the sender itself between clock and bus
constexpr std::uint32_t id = 0x181;

void sleep(double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

class Bus {
public:
    void send(std::uint32_t its_id, const void* bytes, std::size_t size, bool flexible = false) {
        canfd_frame frame{};
        frame.can_id = its_id;
        frame.len = static_cast<std::uint8_t>(size);
        std::memcpy(frame.data, bytes, size);
        // The buffer of the socket is full: the receiver has not had the processor yet.
        const std::size_t whole = flexible ? CANFD_MTU : CAN_MTU;
        for (int i = 0; i < 100 && write(number_, &frame, whole) < 0 && errno == ENOBUFS; ++i) sleep(1e-4);
    }
    void good() {
        const double now = seconds_now();
        send(id, &now, sizeof now);
    }
    void open() {
        if (number_ >= 0) close(number_);
        number_ = socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
        const int yes = 1;
        setsockopt(number_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &yes, sizeof yes);
        sockaddr_can address{};
        address.can_family = AF_CAN;
        address.can_ifindex = static_cast<int>(if_nametoindex("vcan0"));
        if (bind(number_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
            std::perror("vcan0"), std::exit(1);
    }

private:
    int number_ = -1;
};

// One fault, or a burst of them; returns how many.
int inject(Bus& bus, std::mt19937& random) {
    unsigned char bytes[64];
    for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
    const double nan = std::numeric_limits<double>::quiet_NaN(), far = 1e30;
    switch (random() % 12) {
        case 0: bus.send(id, bytes, random() % 8); return 1;      // too short
        case 1: bus.send(id | CAN_RTR_FLAG, bytes, 8); return 1;  // remote
        case 2: bus.send(id | CAN_EFF_FLAG, bytes, 8); return 1;  // of the other length
        case 3: bus.send((random() & CAN_EFF_MASK) | CAN_EFF_FLAG, bytes, 8); return 1;  // unknown
        case 4: bus.send(0x182 + random() % 0x600, bytes, 8); return 1;
        case 5: bus.send(CAN_ERR_FLAG | (random() & CAN_ERR_MASK), bytes, 8); return 1;
        case 6: bus.send(CAN_ERR_FLAG | CAN_ERR_BUSOFF, bytes, 8); return 1;
        case 7: bus.send(id, &nan, 8); return 1;
        case 8: bus.send(id, &far, 8); return 1;
        case 9: bus.send(id, bytes, random() % 7, true); return 1;  // flexible, too short
        case 10:
            if (random() % 50 == 0) sleep(2 * max_age);  // silence
            return 1;
        default: {
            const int burst = 200;  // back to back: faster than a full bus at 1 Mbit/s
            for (int i = 0; i < burst; ++i) bus.send(0x182 + random() % 0x600, bytes, 8);
            return burst;
        }
    }
}

bool becomes(const std::function<bool()>& condition) {
    for (const double until = seconds_now() + 20; seconds_now() < until; sleep(0.001))
        if (condition()) return true;
    return false;
}

double processor_time(int whose) {
    rusage usage{};
    getrusage(whose, &usage);
    const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

int run(int wanted, unsigned seed) {
    CanLinkSettings settings;
    settings.name = "link";
    settings.interface = "vcan0";
    settings.retry = 0.01;
    settings.retry_max = 0.04;
    CanChannel channel;
    channel.name = "time";
    channel.match.id = id;
    channel.signal = {0, 64, false, CanSignal::Type::f64};
    channel.limits.max_age = max_age;
    channel.limits.min = 0;
    channel.limits.max = 1e12;
    settings.channels = {channel};
    CanLink link(settings, [](const std::string&) {});
    link.start();
    const auto reading = [&] {
        const std::lock_guard lock(link.state().mutex);
        return link.state().judges[0].at(seconds_now());
    };
    std::atomic<bool> over{false};
    std::atomic<long> looks{0}, valid{0}, stale{0};
    std::thread observer([&] {
        for (; !over; sleep(0.0005)) {
            const Reading its = reading();
            ++looks;
            if (!its.valid) continue;
            ++valid;
            const double age = seconds_now() - its.value;
            if (its.age > max_age || age < 0 || age > max_age + slack) ++stale;
        }
    });
    Bus bus;
    bus.open();
    std::mt19937 random(seed);
    int faults = 0, removals = 0;
    bool recovers = true;
    const double began = seconds_now();
    while (faults < wanted && recovers) {
        for (int i = 0; i < 3; ++i) bus.good();
        faults += inject(bus, random);
        if (random() % 20 == 0) sleep(0.001);
        if (faults / (wanted / 4 + 1) > removals) {  // a few times
            ++removals;
            const char* const command = removals % 2 != 0
                                            ? "ip link set vcan0 down && sleep 0.1 && ip link set vcan0 up"
                                            : "ip link del vcan0 && sleep 0.1 && ip link add vcan0 type vcan "
                                              "&& ip link set vcan0 mtu 72 up";
            if (std::system(command) != 0) return 1;
            bus.open();
            ++faults;
            recovers = becomes([&] {
                bus.good();
                return reading().valid;
            });
        }
    }
    const double took = seconds_now() - began;
    recovers = recovers && becomes([&] {
                   bus.good();
                   return reading().valid;
               });
    sleep(2 * max_age);
    const bool old = !reading().valid;
    over = true;
    observer.join();
    const double stopping = seconds_now();
    link.stop(5);
    const double stopped = seconds_now() - stopping;
    std::printf(
        "%d faults in %.1f s, %ld looks, %ld %% of them valid, %ld stale, %d removals of the interface, "
        "processor %.0f %%\n",
        faults, took, looks.load(), 100 * valid / std::max<long>(looks, 1), stale.load(), removals,
        100 * processor_time(RUSAGE_SELF) / took);
    const bool good = recovers && old && stale == 0 && valid > 0 && stopped < 1;
    if (!good) std::printf("recovers %d, becomes old %d, ended after %.3f s\n", recovers, old, stopped);
    return good ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
    return argc == 3 ? run(std::atoi(argv[1]), static_cast<unsigned>(std::atoi(argv[2]))) : 2;
}
