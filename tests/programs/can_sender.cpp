// SPDX-License-Identifier: GPL-2.0-or-later
// Sends frames with the ids 0x100 to 0x13F on vcan0, each with the time of the clock in s as a float of 64
// bits, until it is ended: can_sender RATE. For scripts/sensor-speed.
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

static double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int main(int argc, char** argv) {
    const double rate = argc == 2 ? std::atof(argv[1]) : 0;
    const int bus = socket(PF_CAN, SOCK_RAW, CAN_RAW);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex("vcan0"));
    if (rate <= 0 || bind(bus, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return 2;
    const double began = now();
    for (double sent = 0, shown = began;;) {
        for (const double due = (now() - began) * rate; sent < due; ++sent) {
            can_frame frame{};
            frame.can_id = 0x100 + static_cast<unsigned>(sent) % 64;
            frame.can_dlc = 8;
            const double time = now();
            std::memcpy(frame.data, &time, sizeof time);
            if (write(bus, &frame, sizeof frame) < 0) std::this_thread::yield();
        }
        if (now() > shown + 1) {
            shown = now();
            std::printf("%.0f frames/s\n", sent / (shown - began));
            std::fflush(stdout);
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}
