// SPDX-License-Identifier: GPL-2.0-or-later
// hal_stream_dump TYPES COUNT FILE: writes COUNT records of LinuxCNC's `sampler` channel 0, as they are in
// memory.
//
// A record is its number and then its values, each of 8 bytes: the bits of a float, the number of an integer
// or a bit. halsampler would round them to six decimals.
#include <hal.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>

namespace {

constexpr int sampler_key = 0x48534130;

std::int64_t bits_of(const hal_stream_data& value, char type) {
    std::int64_t bits = 0;
    if (type == 'f')
        std::memcpy(&bits, &value.f, sizeof bits);
    else
        bits = type == 'b' ? value.b : type == 's' ? value.s : static_cast<std::int64_t>(value.u);
    return bits;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 4) {
        std::cerr << "usage: hal_stream_dump TYPES COUNT FILE\n";
        return 2;
    }
    const std::string types = argv[1];
    const long count = std::stol(argv[2]);
    std::ofstream file(argv[3], std::ios::binary);
    const int component = hal_init("hal_stream_dump");
    hal_stream_t stream;
    if (component < 0 || hal_ready(component) < 0 ||
        hal_stream_attach(&stream, component, sampler_key, types.c_str()) < 0) {
        std::cerr << "hal_stream_dump: no sampler of " << types << '\n';
        return 1;
    }
    hal_stream_data values[HAL_STREAM_MAX_PINS];
    for (long i = 0; i < count;) {
        unsigned number = 0;
        if (hal_stream_read(&stream, values, &number) < 0) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            continue;
        }
        const std::int64_t index = number;
        file.write(reinterpret_cast<const char*>(&index), sizeof index);
        for (std::size_t pin = 0; pin < types.size(); ++pin) {
            const std::int64_t bits = bits_of(values[pin], types[pin]);
            file.write(reinterpret_cast<const char*>(&bits), sizeof bits);
        }
        ++i;
    }
    hal_stream_detach(&stream);
    hal_exit(component);
    return file.flush() ? 0 : 1;
}
